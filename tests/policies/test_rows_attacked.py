"""A row is a stranger's file: hostile content is refused in one sentence, opens no file and runs no code."""

import json
import re
import sys
from collections.abc import Callable, Iterator
from copy import deepcopy
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.errors import GrindError
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.scoring import evaluate
from grind_env.policies.submitted_rows import read_rows, row_of, verify, write_rows
from tests.command import Grind
from tests.examples import examples, few

Document = dict[str, Any]
SEED = 31415926535897932384


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Document:
    """Return a valid row."""
    folder, problem = tmp_path_factory.mktemp("good"), find_problem("oracle6")
    write_rows(folder / "row.json", [row_of(evaluate("E9000D1", problem, episodes=2), problem, "E9000D1")])
    document: Document = json.loads((folder / "row.json").read_text())
    return document


def refused(grind: Grind, path: Path, *words: object) -> str:
    """Return the sentence with which a row is refused."""
    status, out, err = grind("verify", path, *words)
    assert (status, out, err.count("\n")) == (2, "", 1), (out, err)
    assert err.startswith("grind: ") and str(path) in err and len(err) < 900 and err.strip().isprintable()
    return err


TEXTS = [
    ("", "no JSON"),
    ("{", "no JSON"),
    ("[" * 200_000, "nested too deeply"),
    ('{"format": ' + "[" * 200_000, "nested too deeply"),
    ("[]", "it is no row"),
    ('{"a": 1}', "it is no row"),
    ('{"format": 2}', "of task version 1"),
    ('{"format": 1}', "it is no row of format 2"),
    ('{"format": ' + "9" * 5000 + "}", "no JSON"),
    ('{"format": 2, "task_version": 2}', r"of task version 2, and .*: submit it anew"),
]


@pytest.mark.parametrize(("text", "said"), TEXTS, ids=range(len(TEXTS)))
def test_json_without_a_row_is_refused(text: str, said: str, tmp_path: Path, grind: Grind) -> None:
    (tmp_path / "row.json").write_text(text)
    assert re.search(said, refused(grind, tmp_path / "row.json", "--seed", SEED))


def test_binary_long_and_missing_files_are_refused(tmp_path: Path, grind: Grind) -> None:
    (tmp_path / "row.json").write_bytes(b'{"\xff": 1}')
    assert "no" in refused(grind, tmp_path / "row.json")
    with (tmp_path / "long.json").open("wb") as file:
        file.truncate(65_000_000)
    assert "more than 64 MB" in refused(grind, tmp_path / "long.json")
    assert "cannot be read" in refused(grind, tmp_path / "none.json")


def put(*keys: str | int, to: Any) -> Callable[[Document], Any]:
    """Return a function that puts a value into a row."""

    def change(row: Document) -> None:
        place: Any = row
        for key in keys[:-1]:
            place = place[key]
        place[keys[-1]] = to

    return change


ATTACKS: list[tuple[Callable[[Document], Any], str]] = [
    (lambda row: row.pop("costs"), "row lacks the key costs"),
    (put("surprise", to=1), "row has an unknown key surprise"),
    (put("\x1b[31m", to=1), "unknown key"),
    (put("policy", to=None), "row.policy is None, but must be a text"),
    (put("costs", to={}), "row.costs is {}, but must be a list"),
    (put("costs", to=[]), "it must have 2 to 10000 costs"),
    (put("costs", to=[1.0] * 10_001), "it must have 2 to 10000 costs"),
    (put("costs", 0, to=float("nan")), r"row.costs\[0\] is nan, but must be a finite number"),
    (put("costs", 0, to=10**400), "but must be a finite number"),
    (put("costs", 0, to=True), "is True, but must be a finite number"),
    (put("first_seed", to=-1), "a first seed from 0"),
    (put("first_seed", to=1.5), "must be a whole number"),
    (put("first_seed", to=2**70), "a first seed from 0"),
    (put("split", to="mine"), "mine"),
    (put("id", to="/etc/passwd"), "id is '/etc/passwd', but must be"),
    (put("id", to="grind/Lathe-v0"), "must be that of an environment of the package"),
    (put("id", to="grind/Task-v0"), "must be that of an environment of the package"),
    (put("plant", to="os:system"), "a row names machine and model of the package"),
    (put("plant", to="meter:1"), "plant is .meter:1., but a row names machine and model"),
    (lambda row: row.update(plant="metre:1", model="model"), "no machine 'metre:1'"),
    (lambda row: row.update(plant="x" * 5000, model="model"), "x"),
    (put("model", to="os:system"), "a row names machine and model of the package"),
    (put("policy", to="os:system"), "policy is 'os:system', but must be of the package"),
    (put("policy", to="/etc/passwd.safetensors"), "policy is '/etc/passwd.safetensors', but must be of the package"),
    (put("policy", to="guarded:/tmp/x.zip"), "policy is"),
    (put("policy", to="guarded:" * 30), "policy is"),
    (put("policy", to="x" * 5000), "its policy has ended"),
    (put("policy", to="nobody"), "its policy has ended .*there is no policy 'nobody'"),
    (put("policy", to="hindsight"), "its policy has ended"),
    (lambda row: row.update(policy="os:system", sha256="0" * 64), "it is of the policy file 'os:system'"),
    (lambda row: row.update(policy="/etc/x.safetensors", sha256="x" * 5000), "it is of the policy file"),
    (put("versions", to={"a": 1}), "row.versions.a is 1, but must be a text"),
]


@pytest.mark.parametrize(("attack", "said"), ATTACKS, ids=range(len(ATTACKS)))
def test_an_invalid_value_in_a_row_is_refused_in_one_sentence(
    attack: Callable[[Document], Any], said: str, good: Document, tmp_path: Path, grind: Grind
) -> None:
    row, path = deepcopy(good), tmp_path / "row.json"
    attack(row)
    path.write_text(json.dumps(row))
    message = refused(grind, path, "--seed", SEED)
    assert re.search(said, message), message


@pytest.fixture
def opened(tmp_path: Path) -> Iterator[list[str]]:
    """Yield the list of the files opened in a folder of secrets."""
    found, on = list[str](), [True]
    secrets = str(tmp_path / "secrets")

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if on and event == "open" and str(arguments[0]).startswith(secrets):
            found.append(str(arguments[0]))

    sys.addaudithook(hook)
    (tmp_path / "secrets").mkdir()
    yield found
    on.clear()


def test_no_path_in_a_row_is_opened(good: Document, tmp_path: Path, grind: Grind, opened: list[str]) -> None:
    agent = tmp_path / "secrets" / "agent.safetensors"
    agent.write_bytes(b"agent")
    opened.clear()
    for change in (
        {"id": str(agent)},
        {"policy": str(agent)},
        {"policy": f"guarded:{agent}"},
        {"policy": str(agent), "sha256": sha256(b"agent").hexdigest()},
        {"plant": str(agent), "model": str(agent)},
    ):
        (tmp_path / "row.json").write_text(json.dumps(good | change))
        refused(grind, tmp_path / "row.json", "--seed", SEED)
    assert opened == []


def test_code_named_in_a_row_runs_only_if_the_user_names_it(
    good: Document, tmp_path: Path, grind: Grind, monkeypatch: pytest.MonkeyPatch
) -> None:
    mark, path = tmp_path / "mark", tmp_path / "row.json"
    evil = f"open({str(mark)!r}, 'w')\n1 / 0\n"
    (tmp_path / "evil.py").write_text(evil)
    monkeypatch.chdir(tmp_path)
    of_file = {"policy": "evil:Evil", "sha256": sha256(evil.encode()).hexdigest()}
    for change in ({"policy": "evil:Evil"}, {"plant": "evil:E", "model": "evil:E"}, of_file):
        path.write_text(json.dumps(good | change))
        refused(grind, path, "--seed", SEED)
    assert not mark.exists()
    assert "ZeroDivisionError" not in refused(grind, path, "--policy", "talk:Talker") and not mark.exists()
    assert "names no policy (division by zero)" in refused(grind, path, "--policy", "evil:Evil")
    assert mark.exists()


def test_texts_of_a_row_are_printed_escaped(
    good: Document, tmp_path: Path, grind: Grind, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    data = TALK.replace("WHAT", "pass")
    (tmp_path / "talk.py").write_text(data)
    row = {"policy": "\x1b]0;mine\x07\nholds", "sha256": sha256(data.encode()).hexdigest()}
    (tmp_path / "row.json").write_text(json.dumps(good | row))
    status, out, _ = grind("verify", tmp_path / "row.json", "--policy", "talk:Talker")
    assert status == 0 and "\x1b" not in out and "\\x1b]0;mine\\x07\\nholds in" in out


TALK = """
import sys, os
from grind_env.policies.choices import Decision
import numpy as np

class Talker:
    name, sees = "E9000D1", "measurements"
    def begin(self, simulation, n):
        print("one line " * 9)
        os.write(1, b"x" * 100)
    def act(self, observation, episodes):
        WHAT
        return Decision(np.full(len(observation), 9000.0), np.ones(len(observation)))
"""


@pytest.mark.parametrize(
    ("what", "status", "said"),
    few(
        [
            ("pass", 0, "drawn episodes: "),
            ("import hidden", 2, r"its policy has ended \(ModuleNotFoundError: No module named 'hidden'\)"),
            ("sys.exit('\\x1bgood bye')", 2, r"its policy has ended \(SystemExit: \\x1bgood bye\)"),
            ("os._exit(3)", 2, "its policy has ended"),
            ("raise ValueError('no\\nmore')", 2, r"its policy has ended \(ValueError: no\)"),
            ("return Decision(np.zeros(3), np.zeros(1))", 2, "its policy has ended"),
            ("return Decision(np.zeros(1), np.zeros(1))", 2, "E and D are of shape"),
            ("return Decision(np.full(len(observation), np.nan), np.ones(len(observation)))", 2, "E is nan"),
            ("return None", 2, "its policy has ended"),
        ],
        2,
    ),
)
def test_verify_reports_the_result_or_the_failure_of_a_policy(
    what: str, status: int, said: str, good: Document, tmp_path: Path, grind: Grind, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    data = TALK.replace("WHAT", what)
    (tmp_path / "talk.py").write_text(data)
    row = good | {"policy": "talk:Talker", "sha256": sha256(data.encode()).hexdigest()}
    (tmp_path / "row.json").write_text(json.dumps(row))
    ended, out, err = grind("verify", tmp_path / "row.json", "--seed", SEED, "--policy", "talk:Talker")
    assert (ended in (0, 1)) == (status == 0), (out, err)
    assert re.search(said, out + err) and "\x1b" not in out + err and "xxx" not in err


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=6,
)


@examples(150)
@given(data=st.data())
def test_any_value_in_a_row_passes_or_is_refused(data: st.DataObject, good: Document, tmp_path: Path) -> None:
    row = deepcopy(good)
    place: Any = row
    while True:
        key = data.draw(st.sampled_from([*place] if isinstance(place, dict) else [*range(len(place))]))
        if isinstance(place[key], dict | list) and place[key] and data.draw(st.booleans()):
            place = place[key]
        else:
            place[key] = data.draw(JSON)
            break
    (tmp_path / "row.json").write_text(json.dumps(row))
    try:
        verify(*read_rows(tmp_path / "row.json"))
    except GrindError as error:
        assert "\n" not in str(error) and len(str(error)) < 900


def test_a_number_of_episodes_without_a_seed_is_refused(good: Document, tmp_path: Path, grind: Grind) -> None:
    path = tmp_path / "row.json"
    path.write_text(json.dumps(good))
    status, out, error = grind("verify", path, "--episodes", "3")
    assert (status, out) == (2, "") and "give it, too, or leave --episodes out" in error
