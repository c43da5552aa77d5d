"""A row is a stranger's file: whatever it holds, it is refused in one sentence, opens nothing and runs nothing."""

import json
import re
import sys
from collections.abc import Callable, Iterator
from copy import deepcopy
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from grind_env.errors import GrindError
from grind_env.policies.evaluation import run_seeds
from grind_env.policies.naming import named_policy
from grind_env.policies.problem import find_problem
from grind_env.policies.rows.making import row_of
from grind_env.policies.rows.row import read_row, write_row
from grind_env.policies.rows.verifying import verify
from tests.command import Grind

Document = dict[str, Any]
SEED = 31415926535897932384


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Document:
    """A row that holds, of a task file."""
    folder = tmp_path_factory.mktemp("good")
    (folder / "mine.toml").write_text('base = "oracle6"\nblocks = 3\n')
    problem = find_problem(str(folder / "mine.toml"))
    policy = named_policy("E9D1", problem.simulation())
    run = run_seeds(policy, problem.simulation(), range(2))
    write_row(folder / "row.json", row_of(run, problem, range(2), policy, "E9D1"))
    document: Document = json.loads((folder / "row.json").read_text())
    return document


def text_file(text: str) -> Document:
    return {"text": text, "sha256": sha256(text.encode("utf-8", "surrogateescape")).hexdigest()}


def refused(grind: Grind, path: Path, *words: object) -> str:
    """The sentence with which a row is refused."""
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
    ("7", "it is no row"),
    ('{"a": 1}', "it is no row"),
    ('{"format": 1}', "of task version 1"),
    ('{"format": 2}', "format is 2, but this version reads 1: submit it anew"),
    ('{"format": ' + "9" * 5000 + "}", "no JSON"),
    ('{"format": 1, "task_version": 2}', r"of task version 2, and .*: submit it anew"),
]


@pytest.mark.parametrize(("text", "said"), TEXTS, ids=range(len(TEXTS)))
def test_what_is_no_row_is_refused(text: str, said: str, tmp_path: Path, grind: Grind) -> None:
    (tmp_path / "row.json").write_text(text)
    assert re.search(said, refused(grind, tmp_path / "row.json", "--seed", SEED))


def test_what_is_no_text_or_too_long_is_refused(tmp_path: Path, grind: Grind) -> None:
    (tmp_path / "row.json").write_bytes(b'{"\xff": 1}')
    assert "no" in refused(grind, tmp_path / "row.json")
    with (tmp_path / "long.json").open("wb") as file:
        file.truncate(65_000_000)
    assert "more than 64 MB" in refused(grind, tmp_path / "long.json")
    assert "cannot be read" in refused(grind, tmp_path / "none.json")


def put(*keys: str | int, to: Any) -> Callable[[Document], Any]:
    """Puts a value into a row."""

    def change(row: Document) -> None:
        place: Any = row
        for key in keys[:-1]:
            place = place[key]
        place[keys[-1]] = to

    return change


def task(text: str, name: str = "mine.toml") -> Callable[[Document], Any]:
    """Another text for one of its files."""
    return lambda row: row["files"].update({name: text_file(text)})


ACTIONS = ("episodes", 0)
ATTACKS: list[tuple[Callable[[Document], Any], str]] = [
    (lambda row: row.pop("episodes"), "row lacks the key episodes"),
    (lambda row: row.pop("policy"), "row lacks the key policy"),
    (put("surprise", to=1), "row has an unknown key surprise"),
    (put("\x1b[31m", to=1), "unknown key"),
    (put("files", "mine.toml", "path", to="/etc/passwd"), "has an unknown key path"),
    (put("policy", to=None), "row.policy is None, but must be a text"),
    (put("sees", to="everything"), "row.sees is 'everything', but must be one of measurements"),
    (put("sees", to=[]), "row.sees is"),
    (put("cost", to=[1.0, 2.0]), "row.cost has 2 numbers, but must have 3"),
    (put("cost", to=[1.0, 2.0, float("nan")]), r"row.cost\[2\] is nan, but must be a finite number"),
    (put("cost_per_good_part", to="free"), "row.cost_per_good_part is 'free'"),
    (put(*ACTIONS, "cost", to=float("inf")), r"row.episodes\[0\].cost is inf"),
    (put(*ACTIONS, "cost", to=10**400), "but must be a finite number"),
    (put(*ACTIONS, "cost", to=True), "is True, but must be a finite number"),
    (put(*ACTIONS, "E", to={}), "must be a list"),
    (put(*ACTIONS, "E", to=[]), r"episodes\[0\] has 0 E and 3 D: give both of every step"),
    (put(*ACTIONS, "D", to=[1.0]), "has 3 E and 1 D"),
    (lambda row: row["episodes"][0].update(E=[9000.0] * 2, D=[1.0] * 2), "has 2 E and D, but must have 3"),
    (lambda row: row["episodes"][0].update(E=[9000.0] * 4, D=[1.0] * 4), "has 4 E and D, but must have 3"),
    (lambda row: row["episodes"][0].update(E=[9000.0] * 10**5, D=[1.0] * 10**5), "but must have 3"),
    (put(*ACTIONS, "E", 1, to=float("nan")), "must be a finite number"),
    (put(*ACTIONS, "E", 1, to=1e12), "an action of it is none: E is 1000000000000 mm/min"),
    (put(*ACTIONS, "E", 1, to=-9000.0), "an action of it is none"),
    (put(*ACTIONS, "E", 1, to=9000.25), "an action of it is none|such a step takes"),
    (put(*ACTIONS, "D", 1, to=99.0), "D is 99, but must be a whole number from 0"),
    (put(*ACTIONS, "D", 1, to=0.5), "D is 0.5, but must be a whole number"),
    (put("episodes", to=[]), "it has 0 episodes, but must have 2 to 10000"),
    (lambda row: row["episodes"].extend(row["episodes"]), "is there twice"),
    (put(*ACTIONS, "seed", to=-1), "not from 0"),
    (put(*ACTIONS, "seed", to=1.5), "must be a whole number"),
    (put(*ACTIONS, "seed", to=2**70), "not from 0"),
    (put("split", to="mine"), "split is 'mine', but must be one of all"),
    (put("id", to="/etc/passwd"), "id is '/etc/passwd', but must be"),
    (put("id", to="grind/Lathe-v0"), "must be that of an environment in which E and D are chosen"),
    (put("id", to="grind/Oracle6-v0"), "a task goes with grind/Task-v0"),
    (put("task", to=""), "a task goes with grind/Task-v0"),
    (put("task", to="/etc/passwd"), "task is '/etc/passwd', but must be one of its files"),
    (put("program", to="mine.toml"), "a program with grind/Job-v0"),
    (put("parts", to=3), "is no part program: leave out its job and its parts"),
    (put("plant", to="os:system"), "it runs the code of its os.py: read that, and give --trust"),
    (put("plant", to="meter:1"), "plant is .meter:1., which does not fit its problem or model"),
    (put("plant", to="metre:1"), "no machine 'metre:1'"),
    (put("plant", to="x" * 5000), "a name is longer than 200"),
    (put("model", to="os:system"), "it runs the code of its os.py"),
    (put("says", to="os:system"), "it runs the code of its os.py"),
    (put("says", to="/etc/passwd.safetensors"), "says is '/etc/passwd.safetensors'"),
    (put("says", to="guarded:/tmp/x.zip"), "says is"),
    (put("says", to="guarded:" * 30), "says is"),
    (put("says", to="agent.safetensors"), "no trained agent"),
    (put("says", to="nobody"), "there is no policy 'nobody'"),
    (put("says", to="handbook"), "what the row carries is another"),
    (put("says", to="constant"), "its policy has ended .*constant has no parameters"),
    (put("parameters", to={"E = 1\n[x]": 1}), "parameters"),
    (put("parameters", to={"speeds": 10**9}), "must have no whole beyond 1000"),
    (put("parameters", to={"E": "x"}), "row.parameters.E is 'x'"),
    (lambda row: row.update(says="constant", parameters={"E": 9.0}), "does not fit"),
    (
        lambda row: row.update(says="constant", parameters={"E": 9.0, "D": 1, "name": 7}),
        "what the row carries is another",
    ),
    (put("files", "mine.toml", "text", to="blocks = 4"), "not what its sha256 is of"),
    (put("files", "mine.toml", "base64", to="!"), "not what its sha256 is of"),
    (put("files", "mine.toml", "text", to="\ud800"), "not what its sha256 is of"),
    (task("blocks = ["), "mine.toml"),
    (
        lambda row: (
            task('base = "oracle6"\nblocks = 1000\n')(row),
            row.update(episodes=[row["episodes"][0] | {"seed": k} for k in range(5001)]),
        ),
        "5001 episodes of 1000 blocks are more than 5000000 blocks in all",
    ),
    (task('base = "/etc/shop.toml"\n'), "names the file '/etc/shop.toml', which is none of the row"),
    (task('base = "../../../../etc/shop.TOML"\n'), "which is none of the row"),
    (task('base = "oracle6"\n[catalogue]\nfiles = ["/etc/hostname"]\n'), "names the file '/etc/hostname'"),
    (task('base = "oracle6"\nplant = "os:system"\n'), "would run the code of a module"),
    (task("a" * 17_000_000), "longer than 16 MB"),
    *(
        (task("", name), "a name leads below the folder of the row|can be no file")
        for name in ("../x", "/etc/x", "a//x", "a\\x", "C:x", "", "..", "a/./x", "a\x00", "a\x1b", "mine.toml/x")
    ),
    (task("", "x" * 300), "a name is longer than 200"),
    (lambda row: row["files"].update({f"{k}.nc": text_file("") for k in range(200)}), "it has 201 files"),
]


@pytest.mark.parametrize(("attack", "said"), ATTACKS, ids=range(len(ATTACKS)))
def test_what_does_not_fit_is_refused_in_one_sentence(
    attack: Callable[[Document], Any], said: str, good: Document, tmp_path: Path, grind: Grind
) -> None:
    row, path = deepcopy(good), tmp_path / "row.json"
    attack(row)
    path.write_text(json.dumps(row))
    message = refused(grind, path, "--seed", SEED)
    assert re.search(said, message), message


@pytest.fixture
def opened(tmp_path: Path) -> Iterator[list[str]]:
    """The files of a folder of secrets that are opened."""
    found, on = list[str](), [True]
    secrets = str(tmp_path / "secrets")

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if on and event == "open" and str(arguments[0]).startswith(secrets):
            found.append(str(arguments[0]))

    sys.addaudithook(hook)
    (tmp_path / "secrets").mkdir()
    yield found
    on.clear()


def test_no_path_of_it_is_opened(good: Document, tmp_path: Path, grind: Grind, opened: list[str]) -> None:
    secret = tmp_path / "secrets" / "secret.toml"
    secret.write_text('base = "oracle6"\n')
    assert opened == [str(secret)]
    opened.clear()
    agent = tmp_path / "secrets" / "agent.safetensors"
    agent.write_bytes(b"agent")
    opened.clear()
    for attack in (
        put("id", to=str(secret)),
        put("task", to=str(secret)),
        put("job", to=str(secret)),
        put("program", to=str(secret)),
        put("says", to=str(agent)),
        put("says", to=f"guarded:{agent}"),
        task(f'base = "{secret}"\n'),
        task(f'base = "oracle6"\n[catalogue]\nfiles = ["{secret}"]\n'),
        task("", str(secret)),
    ):
        row = deepcopy(good)
        attack(row)
        (tmp_path / "row.json").write_text(json.dumps(row))
        refused(grind, tmp_path / "row.json", "--seed", SEED, "--trust")
    assert opened == [] and secret.read_text() == 'base = "oracle6"\n'


def test_no_code_of_it_is_run_unless_it_is_trusted(good: Document, tmp_path: Path, grind: Grind) -> None:
    mark, path = tmp_path / "mark", tmp_path / "row.json"
    for name in ("evil.py", "numpy.py", "sitecustomize.py"):
        good = deepcopy(good)
        good["files"][name] = text_file(f"open({str(mark)!r}, 'w')\n1 / 0\n")
    path.write_text(json.dumps(good))
    assert grind("verify", path)[0] == 0 and grind("verify", path, "--seed", SEED)[0] in (0, 1)
    for key in ("says", "plant", "model"):
        path.write_text(json.dumps({**good, key: "evil:Evil"}))
        assert "it runs the code of its evil.py" in refused(grind, path, "--seed", SEED)
    assert not mark.exists()
    path.write_text(json.dumps({**good, "says": "evil:Evil"}))
    assert "evil:Evil' names no policy (division by zero)" in refused(grind, path, "--seed", SEED, "--trust")
    assert mark.exists()


def test_what_it_says_is_printed_escaped(good: Document, tmp_path: Path, grind: Grind) -> None:
    row = deepcopy(good) | {"policy": "\x1b]0;mine\x07\nreplayed"}
    (tmp_path / "row.json").write_text(json.dumps(row))
    status, out, _ = grind("verify", tmp_path / "row.json")
    assert status == 0 and "\x1b" not in out and "\\x1b]0;mine\\x07\\nreplayed (sees" in out


TALK = """
import sys, os
from grind_env.policies.choices import Decision
import numpy as np

class Talker:
    name, sees = "constant E 9 m/min, D 1", "measurements"
    def begin(self, simulation, n):
        print("one line " * 9)
        os.write(1, b"x" * 100)
    def act(self, observation, episodes):
        WHAT
        return Decision(np.full(len(observation), 9000.0), np.ones(len(observation)))
"""


@pytest.mark.parametrize(
    ("what", "status", "said"),
    [
        ("pass", 0, "measured-only"),
        ("import hidden", 2, r"its policy has ended \(ModuleNotFoundError: No module named 'hidden'\)"),
        ("sys.exit('\\n\\x1bgood bye')", 2, r"its policy has ended \(\\x1bgood bye\)"),
        ("os._exit(3)", 2, "its policy has ended"),
        ("raise ValueError('no\\nmore')", 2, r"its policy has ended \(ValueError: no\)"),
        ("return Decision(np.zeros(3), np.zeros(1))", 2, "its policy has ended"),
        ("return Decision(np.zeros(1), np.zeros(1))", 2, "E and D are of shape"),
        ("return Decision(np.full(len(observation), np.nan), np.ones(len(observation)))", 2, "E is nan"),
        ("return None", 2, "its policy has ended"),
    ],
)
def test_whatever_its_policy_does_is_told(
    what: str, status: int, said: str, good: Document, tmp_path: Path, grind: Grind
) -> None:
    row = deepcopy(good) | {"says": "talk:Talker"}
    row["files"] |= {"talk.py": text_file(TALK.replace("WHAT", what)), "hidden.py": text_file("")}
    (tmp_path / "row.json").write_text(json.dumps(row))
    ended, out, err = grind("verify", tmp_path / "row.json", "--seed", SEED, "--trust")
    assert (ended in (0, 1)) == (status == 0), (out, err)
    assert re.search(said, out + err) and "\x1b" not in out + err and ("xxx" not in err or "_exit" in what)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=6,
)


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(data=st.data())
def test_any_value_anywhere_is_refused_or_does_no_harm(data: st.DataObject, good: Document, tmp_path: Path) -> None:
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
        verify(read_row(tmp_path / "row.json"))
    except GrindError as error:
        assert "\n" not in str(error) and len(str(error)) < 900


def test_a_number_of_episodes_without_a_seed_is_not_ignored(good: Document, tmp_path: Path, grind: Grind) -> None:
    path = tmp_path / "row.json"
    path.write_text(json.dumps(good))
    status, out, error = grind("verify", path, "--episodes", "3")
    assert (status, out) == (2, "") and "give it, too, or leave --episodes out" in error
