"""Rows of the results table as files: written, read, and re-run with a policy that gets measurements only."""

import hashlib
import json
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import grind_env
from grind_env.dataclass_json import FormError
from grind_env.errors import GrindError
from grind_env.policies import submitted_rows as submissions
from grind_env.policies.evaluation import SEEDS, SEEDS_EACH, run_seeds
from grind_env.policies.policy_lookup import SHIPPED, named_policy
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.score_statistics import prediction
from grind_env.policies.submitted_rows import SubmittedRow, read_rows, row_of, track_row, verify, write_rows
from grind_env.policies.track import run_shifts
from tests.command import Grind
from tests.examples import few

SEED = 31415926535897932384
PLATES = find_problem("power_limited")

Submit = Callable[..., Path]


@pytest.fixture
def submit(grind: Grind, tmp_path: Path) -> Submit:
    """Return a function that writes a row with `grind evaluate`."""

    def call(*words: object, episodes: int = 3) -> Path:
        path = tmp_path / "row.json"
        status, _, err = grind("evaluate", *words, "--episodes", episodes, "--submit", path)
        assert (status, err) == (0, "")
        return path

    return call


def plates_row(policy: str, episodes: int = 3) -> SubmittedRow:
    return row_of(grind_env.evaluate(policy, PLATES, episodes=episodes), PLATES, policy)


@pytest.mark.parametrize("env", few(["power_limited", "reciprocation", "wide_plates", "job_shop", "grind/Job-v0"]))
def test_verify_re_runs_a_submitted_row(env: str, submit: Submit, grind: Grind) -> None:
    path = submit("--env", env, "--policy", "E12000D1")
    status, out, err = grind("verify", path)
    assert (status, err) == (0, "") and "re-run of 3 episodes: " in out


def test_a_row_is_read_as_written(tmp_path: Path) -> None:
    row = plates_row("look_ahead")
    write_rows(tmp_path / "row.json", [row])
    assert read_rows(tmp_path / "row.json") == [row]
    document = json.loads((tmp_path / "row.json").read_text())
    assert document["first_seed"] == 2_000_000 and len(document["costs"]) == 3
    assert document["versions"]["grind_env"] == grind_env.__version__


PLATE = str(Path(grind_env.__file__).with_name("examples") / "plate_g82.nc")
AGENT = SHIPPED / "plain_gru" / "power_limited.safetensors"


@pytest.mark.parametrize(
    ("says", "named"),
    few(
        [
            ("E7000D1", "E7000D1"),
            ("look_ahead", "look_ahead"),
            ("guarded:adaptive_rule", "guarded:adaptive_rule"),
            (str(AGENT), "power_limited.safetensors"),
            (None, "plain_gru"),
        ]
    ),
)
def test_verify_runs_the_policy_on_other_episodes(says: str | None, named: str, submit: Submit, grind: Grind) -> None:
    path = submit(*(["--policy", says] if says else []), episodes=6)
    (row,) = read_rows(path)
    assert row.policy == named
    assert row.sha256 == (hashlib.sha256(AGENT.read_bytes()).hexdigest() if says == str(AGENT) else "")
    file = ["--policy", AGENT] if row.sha256 else []
    status, out, err = grind("verify", path, *file, "--seed", SEED, "--episodes", 4)
    assert status in (0, 1) and err == ""
    # the printed cost is that of the named policy on these episodes
    policy = named_policy(says or str(AGENT), PLATES.simulation())
    mean = run_seeds(policy, PLATES.simulation(), submissions.fresh_seeds(SEED, 4)).cost.mean()
    assert f"\n4 drawn episodes: {mean:.5g} $ each" in out


@pytest.mark.nightly
def test_verify_re_runs_a_row_on_its_own_machine(submit: Submit, grind: Grind) -> None:
    path = submit("--policy", "belief_rule", "--plant", "meter:7", "--model", "soft:3", episodes=16)
    (row,) = read_rows(path)
    assert (row.plant, row.model) == ("meter:7", "soft:3")
    status, out, err = grind("verify", path, "--seed", SEED)
    assert (status, err) == (0, ""), out
    write_rows(path, [replace(row, model="model")])
    assert grind("verify", path)[0] == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--policy", "hindsight"), "a row is of an environment of the package and a policy that sees measurements"),
        (("--policy", "E9000D1", "--task", "mine.toml"), "a row is of an environment of the package"),
        (("--policy", "E12000D1", "--program", PLATE), "a row is of an environment of the package"),
        (("--policy", "constant", "--parameters", "."), "leave out --parameters or --submit"),
        (("--policy", "adaptive_rule", "--plant", "my_plant:METER"), "names machine and model of the package"),
        (("--policy", "agent.zip", "--trust"), "'agent.zip' cannot be submitted: load the .zip in a module"),
    ],
)
def test_results_nobody_else_can_repeat_are_not_submitted(
    words: tuple[str, ...], said: str, own: Path, grind: Grind, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(own)
    (own / "mine.toml").write_text('base = "oracle6"\nblocks = 3\n')
    status, out, err = grind("evaluate", *words, "--episodes", 2, "--submit", "row.json")
    assert (status, out) == (2, "") and said in err and not (own / "row.json").exists()


OWN_POLICY = """
from dataclasses import dataclass
import numpy as np
from grind_env.policies.choices import Decision

print("imported")

@dataclass
class Mine:
    name: str = "mine"
    sees: str = "measurements"
    E: float = 7000.0

    def begin(self, simulation, episodes):
        self.simulation = simulation

    def act(self, observation, episodes):
        seen = self.simulation.read(observation)
        return Decision(np.full(len(observation), self.E), (seen["peak_power"] > 3000.0).astype(float))

    def learn(self, shift):
        self.E *= 0.9 if shift.bad.any() or shift.observations.dtype != np.float32 else 1.02

MINE = Mine()
"""
OWN_PLANT = """
from dataclasses import replace
from grind_env.plants import find_plant

METER = replace(find_plant("meter:3"), name="mine")
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a user's own policy and plant."""
    folder = tmp_path / "own"
    folder.mkdir()
    (folder / "my_policy.py").write_text(OWN_POLICY)
    (folder / "my_plant.py").write_text(OWN_PLANT)
    monkeypatch.syspath_prepend(folder)
    for name in ("my_policy", "my_plant"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return folder


@pytest.mark.parametrize("name", few(["Mine", "MINE"]))
def test_verify_runs_a_users_policy_only_if_it_is_named(
    name: str, own: Path, submit: Submit, grind: Grind, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(own)
    said = f"guarded:my_policy:{name}"
    path = submit("--policy", said, episodes=6)
    status, out, err = grind("verify", path, "--seed", SEED)
    assert (status, out) == (2, "") and f"it is of the policy file '{said}' with the SHA-256" in err
    status, out, err = grind("verify", path, "--seed", SEED, "--policy", said)
    assert (status, err) == (0, "") and "drawn episodes: " in out
    with (own / "my_policy.py").open("a") as file:
        file.write("\n")
    assert grind("verify", path, "--policy", said)[0] == 2


KNOWS = """
import numpy as np
from grind_env.policies.choices import Decision

class Knows:
    name = "knows"
    sees = "measurements"

    def begin(self, simulation, n):
        rngs = [np.random.default_rng(seed) for seed in range(2_000_000, 2_000_006)]
        self.known, self.mine = simulation.observe(simulation.start(rngs)), None

    def act(self, observation, episodes):
        if self.mine is None:
            self.mine = (self.known[:, None] == observation).all(axis=2).any(axis=0)
        return Decision(np.full(len(observation), 7000.0), self.mine.astype(float))
"""
CHEAT = """
import gc, sys
import numpy as np
from grind_env.policies.choices import Decision
from grind_env.envs.episode_state import Episodes

class Cheat:
    name = "cheat"
    sees = "measurements"
    way = "WAY"

    def begin(self, simulation, n):
        self.simulation, self.caught, self.mine = simulation, [], []
        if self.way == "simulation":  # whatever it is asked to observe
            observe = simulation.observe
            def spy(episodes):
                self.caught.append(episodes)
                return observe(episodes)
            simulation.observe = spy

    def act(self, observation, episodes):
        if self.way == "argument" and episodes is not None:
            raise RuntimeError("caught the argument")
        if self.way == "simulation" and self.caught:
            raise RuntimeError("caught the simulation")
        if self.way == "frames":
            frame = sys._getframe()
            while frame is not None:
                if any(isinstance(each, Episodes) for each in frame.f_locals.values()):
                    raise RuntimeError("caught the frames")
                frame = frame.f_back
        if self.way == "objects" and any(isinstance(each, Episodes) for each in gc.get_objects()):
            raise RuntimeError("caught the objects")
        if self.way == "words" and any("SEED" in each for each in sys.argv):
            raise RuntimeError("caught the words")
        return Decision(np.full(len(observation), 7000.0), np.ones(len(observation)))
"""


@pytest.mark.parametrize("way", few(["simulation", "argument", "frames", "objects", "words"]))
def test_verify_gives_a_policy_nothing_but_measurements(
    way: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "my_cheat.py").write_text(CHEAT.replace("WAY", way).replace("SEED", str(SEED)))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "my_cheat", raising=False)
    monkeypatch.setattr("sys.argv", ["grind", "verify", "--seed", str(SEED)])
    cheat: Any = named_policy("my_cheat:Cheat", PLATES.simulation(), modules=True)
    # in one process with the episodes the same code finds them
    seeds, simulation = range(2_000_000, 2_000_004), find_problem("power_limited").simulation()
    with pytest.raises(RuntimeError, match="caught the"):
        if way == "argument":
            cheat.sees = "state"
        run_seeds(cheat, simulation, seeds)
    monkeypatch.chdir(tmp_path)
    honest = replace(plates_row("E7000D1", 4), policy="my_cheat:Cheat", sha256=submissions.digest(Path("my_cheat.py")))
    assert verify(honest, "my_cheat:Cheat", seed=SEED)[0]


def test_verify_detects_costs_of_another_policy(grind: Grind, tmp_path: Path) -> None:
    write_rows(tmp_path / "row.json", [replace(plates_row("look_ahead", 6), policy="E3000D0")])
    status, out, _ = grind("verify", tmp_path / "row.json", "--seed", SEED)
    assert status == 1 and "re-run of 6 episodes: " in out and "drawn" not in out


@pytest.mark.nightly
def test_verify_detects_a_policy_fitted_to_the_seeds_of_its_row(
    tmp_path: Path, grind: Grind, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The policy dresses only in episodes whose first observation is one of the row's episodes."""
    (tmp_path / "knows.py").write_text(KNOWS)
    monkeypatch.chdir(tmp_path)
    row = replace(plates_row("E7000D1", 6), policy="knows:Knows", sha256=submissions.digest(tmp_path / "knows.py"))
    write_rows(tmp_path / "row.json", [row])
    assert grind("verify", "row.json", "--policy", "knows:Knows")[0] == 0
    status, out, _ = grind("verify", "row.json", "--policy", "knows:Knows", "--seed", SEED)
    assert status == 1 and "6 drawn episodes: " in out


def test_drawn_seeds_follow_the_documented_formula_and_exceed_all_other_seeds() -> None:
    seeds = submissions.fresh_seeds(SEED, 200)
    for k, seed in enumerate(seeds):
        bits = int(hashlib.sha256(f"grind verify {SEED} {k}".encode()).hexdigest(), 16) >> (256 - 62)
        assert seed == 2**62 + bits
    assert len({*seeds, *submissions.fresh_seeds(SEED + 1, 200)}) == 400
    assert min(seeds) > max(first + SEEDS_EACH for first in SEEDS.values())


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("my_policy:Yours", "'my_policy:Yours' names no policy .*Yours"),
        ("nowhere:Mine", "'nowhere:Mine' names no policy .No module named 'nowhere'"),
        ("my_policy:np", "'my_policy:np' names no policy"),
        ("my_policy:dataclass", "is no policy"),
    ],
)
def test_a_wrong_name_in_a_policy_module_is_refused(name: str, said: str, own: Path) -> None:
    with pytest.raises(GrindError, match=said):
        grind_env.evaluate(name, PLATES, episodes=2)


def test_only_an_argument_can_name_a_policy_module(own: Path) -> None:
    with pytest.raises(GrindError, match="there is no policy 'my_policy:Mine'"):
        named_policy("my_policy:Mine", PLATES.simulation())
    assert "my_policy" not in sys.modules
    found = grind_env.evaluate("my_policy:Mine", PLATES, episodes=2)
    assert (found.policy, found.sees, found.first_seed) == ("mine", "measurements", 2_000_000)


@pytest.mark.nightly
def test_verify_re_runs_a_track_row_also_on_drawn_machines(
    own: Path, grind: Grind, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(own)
    machines = ("public:1", "public:2", "public:3")
    monkeypatch.setattr(submissions, "MACHINES", machines)
    monkeypatch.setattr(submissions, "BASELINE", "E7000D1")

    def block_costs(name: str) -> np.ndarray:
        made = [(named_policy(name, PLATES.simulation(), modules=True), plant) for plant in machines]
        return np.array([run_shifts(policy, plant, [0]).cost.mean() for policy, plant in made])

    costs, robust = block_costs("my_policy:Mine"), block_costs("E7000D1")
    row, words = track_row("my_policy:Mine", costs, robust), ("verify", "row.json", "--policy", "my_policy:Mine")
    write_rows(own / "row.json", [row])
    status, out, err = grind(*words, "--seed", SEED)
    assert (status, err) == (0, "")
    assert f"re-run of 3 runs: {costs.mean():.5g} $ a block and {robust.mean():.5g} $ with" in out
    assert "3 drawn runs: " in out and "times as much; predicted: " in out
    write_rows(own / "row.json", [replace(row, robust=tuple(1.01 * robust))])
    status, out, _ = grind(*words)
    assert status == 1 and "drawn" not in out


def test_a_track_row_compares_summed_costs_and_needs_all_machines() -> None:
    both = np.array([[2.0, 3.0, 4.0], [4.0, 3.0, 5.0]])
    assert submissions._compared(both).mean() == pytest.approx(0.75) and submissions._compared(both[:1]).mean() == 3.0
    # a policy with one cost ratio on every machine is predicted exactly
    assert prediction(submissions._compared(both[[0, 0]] * [[0.9], [1.0]]), 5) == pytest.approx((0.9, 0.9, 0.9))
    with pytest.raises(FormError, match="a row of the track is of grind/PowerLimited-v0 and has costs of 20 machines"):
        track_row("E7000D1", both[0], both[1])
