"""Rows of a table as files: written, replayed, and run again where nothing but measurements comes to their policy."""

import hashlib
import json
import math
import shutil
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import grind_env
from grind_env.errors import GrindError
from grind_env.policies.evaluation import SEEDS, SEEDS_EACH, run_seeds
from grind_env.policies.naming import SHIPPED, named_policy
from grind_env.policies.problem import find_problem
from grind_env.policies.rows.making import row_of
from grind_env.policies.rows.row import Row, read_row, write_row
from grind_env.policies.rows.verifying import fresh_seeds, verify
from grind_env.policies.statistics import prediction
from tests.command import Grind

EXAMPLES = Path(grind_env.__file__).with_name("examples")
SEED = 31415926535897932384
PLATES = find_problem("power_limited")

PLAIN = named_policy("E7D1", PLATES.simulation())
FEW = run_seeds(PLAIN, PLATES.simulation(), range(2))

Submit = Callable[..., Path]


@pytest.fixture
def submit(grind: Grind, tmp_path: Path) -> Submit:
    """Writes a row with `grind evaluate`."""

    def call(*words: object, episodes: int = 3) -> Path:
        path = tmp_path / "row.json"
        status, _, err = grind("evaluate", *words, "--episodes", episodes, "--submit", path)
        assert (status, err) == (0, "")
        return path

    return call


def plates_row(policy: str, episodes: int = 3) -> Row:
    seeds = range(2_000_000, 2_000_000 + episodes)
    made = named_policy(policy, PLATES.simulation())
    return row_of(run_seeds(made, PLATES.simulation(), seeds), PLATES, seeds, made, policy)


@pytest.mark.parametrize("env", ["power_limited", "reciprocation", "wide_plates", "job_shop", "grind/Job-v0"])
def test_a_row_is_replayed_and_holds(env: str, submit: Submit, grind: Grind) -> None:
    path = submit("--env", env, "--policy", "E12D1")
    status, out, err = grind("verify", path)
    assert (status, err) == (0, "")
    assert "replayed: all 3 episodes cost what it says, to the bit" in out


@pytest.mark.bits
def test_its_actions_cost_in_the_environment_what_it_says() -> None:
    row = plates_row("adaptive_rule")
    env = gym.make("grind/PowerLimited-v0", info="full")
    for each in row.episodes:
        env.reset(seed=each.seed)
        actions = env.unwrapped.codec.encode(each.E, each.D)
        steps = [env.step(action) for action in actions]
        assert [over for _, _, over, _, _ in steps] == [False] * (len(steps) - 1) + [True]
        assert sum(info["block_cost"] for *_, info in steps) == pytest.approx(each.cost, rel=1e-12)
        assert sum(info["good_parts"] for *_, info in steps) == pytest.approx(each.good, rel=1e-12)


def test_a_row_is_read_as_it_was_written(tmp_path: Path) -> None:
    row = plates_row("look_ahead")
    write_row(tmp_path / "row.json", row)
    assert read_row(tmp_path / "row.json") == row
    document = json.loads((tmp_path / "row.json").read_text())
    assert document["episodes"][0]["seed"] == 2_000_000
    mean = sum(each["cost"] for each in document["episodes"]) / 3
    assert document["cost"][0] == pytest.approx(mean) == document["prediction"][0]
    assert document["provenance"]["grind_env"] == grind_env.__version__


@pytest.mark.parametrize(
    ("says", "named"),
    [
        ("E7D1", "E7D1"),
        ("look_ahead", "look_ahead"),
        ("guarded:adaptive_rule", "guarded:adaptive_rule"),
        (str(SHIPPED / "power_limited.safetensors"), "agent.safetensors"),
        (None, "agent.safetensors"),
    ],
)
def test_a_policy_of_measurements_is_run_on_other_episodes(
    says: str | None, named: str, submit: Submit, grind: Grind
) -> None:
    path = submit(*(["--policy", says] if says else []), episodes=6)
    row = read_row(path)
    assert row.says == named
    status, out, err = grind("verify", path, "--seed", SEED, "--episodes", 4)
    assert (status, err) == (0 if "\nmeasured-only" in out else 1, "")
    # what it costs there is what the policy as it was named costs there
    policy = named_policy(says or str(SHIPPED / "power_limited.safetensors"), PLATES.simulation())
    mean = run_seeds(policy, PLATES.simulation(), fresh_seeds(SEED, 4)).cost.mean()
    assert f"measured-only: 4 other episodes cost {mean:.4g} $ each" in out


def test_an_agent_is_carried_byte_by_byte(submit: Submit) -> None:
    agent = SHIPPED / "power_limited.safetensors"
    (name, file) = next(iter(read_row(submit("--policy", agent)).files.items()))
    assert (name, file.sha256) == ("agent.safetensors", hashlib.sha256(agent.read_bytes()).hexdigest())
    assert file.data(name) == agent.read_bytes()


def test_a_scripted_policy_carries_its_own_parameters(tmp_path: Path, submit: Submit, grind: Grind) -> None:
    shipped = grind_env.policies.tuned.CONFIGS / "power_limited.toml"
    configs = tmp_path / "configs"
    configs.mkdir()
    text = shipped.read_text()
    (configs / "power_limited.toml").write_text(text.replace("\nE = 7", "\nE = 9").replace("\nE = 6", "\nE = 9"))
    path = submit("--policy", "constant", "--configs", configs)
    shutil.rmtree(configs)
    row = read_row(path)
    assert row.parameters["E"] != read_row(submit("--policy", "constant")).parameters["E"]
    write_row(path, row)
    assert "episodes cost" in grind("verify", path, "--seed", SEED)[1]
    speed = 1000.0 * row.parameters["E"]
    assert row.episodes[0].E[0] == pytest.approx(speed, abs=0.5) and 9000.0 < speed < 10_000.0


def test_a_users_program_job_and_catalogue_travel_with_it(tmp_path: Path, submit: Submit, grind: Grind) -> None:
    shop = tmp_path / "shop"
    (shop / "tools").mkdir(parents=True)
    program = (EXAMPLES / "plate_g82.nc").read_text().replace("STOCK 0.2 MM", "STÜCK").split("\nO9100")
    (shop / "plate.nc").write_text(program[0], encoding="latin-1")
    (shop / "O9100.nc").write_text(f"O9100{program[1]}")
    (shop / "O77.nc").write_text("O77\nM99\n")
    job = (EXAMPLES / "plate_g82.toml").read_text().replace('wheel = "a60j"', 'wheel = "mine"')
    (shop / "own.toml").write_text(f'{job}\n[catalogue]\nfiles = ["tools/wheels.toml"]\n')
    (shop / "tools" / "wheels.toml").write_text('[wheel.mine]\nbase = "a60j"\n')
    path = submit("--program", shop / "plate.nc", "--job", shop / "own.toml", "--parts", 2, "--policy", "E12D1")
    row = read_row(path)
    assert {*row.files} == {"plate.nc", "O9100.nc", "own.toml", "tools/wheels.toml"}
    assert row.files["plate.nc"].data("plate.nc") == (shop / "plate.nc").read_bytes()
    shutil.rmtree(shop)
    assert grind("verify", path, "--seed", SEED)[0] == 0


def test_an_inch_program_is_replayed(tmp_path: Path, submit: Submit, grind: Grind) -> None:
    text = (EXAMPLES / "plate_g82.nc").read_text()
    (tmp_path / "inch.nc").write_text(text.replace("N60 M01", "N60 G70"))
    (tmp_path / "inch.toml").write_text((EXAMPLES / "plate_g82.toml").read_text())
    text = text.replace("N60 M01", "N60 M01\nN65 G70").replace(
        "Y-.2 J-.005 L4 F60. E9000.", "Y-.00787 J-.0002 L4 F2.4 E354."
    )
    (tmp_path / "inch.nc").write_text(text.replace("N80 G80", "N80 G80\nN85 G71"))
    path = submit("--program", tmp_path / "inch.nc", "--policy", "E12D1")
    assert not float(read_row(path).episodes[0].E[1]).is_integer()
    assert grind("verify", path)[0] == 0


def test_a_users_task_and_what_it_stands_on_travel_with_it(tmp_path: Path, submit: Submit, grind: Grind) -> None:
    shop = tmp_path / "shop"
    (shop / "bases").mkdir(parents=True)
    (shop / "mine.toml").write_text('base = "bases/first.toml"\nblocks = 4\nplant = "meter:7"\n')
    (shop / "bases" / "first.toml").write_text('base = "oracle6"\n[catalogue]\nfiles = ["../lots.toml"]\n')
    (shop / "lots.toml").write_text('[material.hard]\nbase = "aisi_52100"\nkA = 1e-5\n'.replace("kA = 1e-5\n", ""))
    path = submit("--task", shop / "mine.toml", "--policy", "E9D1")
    row = read_row(path)
    assert {*row.files} == {"mine.toml", "bases/first.toml", "lots.toml"} and (row.plant, row.model) == (
        "meter:7",
        "model",
    )
    shutil.rmtree(shop)
    assert grind("verify", path, "--seed", SEED)[0] == 0


OWN_POLICY = """
from dataclasses import dataclass
import numpy as np
from grind_env.policies.choices import Decision

print("imported")

@dataclass
class Mine:
    name: str = "mine"
    sees: str = "measurements"

    def begin(self, simulation, episodes):
        self.simulation = simulation

    def act(self, observation, episodes):
        seen = self.simulation.read(observation)
        return Decision(np.full(len(observation), 7000.0), (seen["peak_power"] > 3000.0).astype(float))

MINE = Mine()
"""
OWN_PLANT = """
from dataclasses import replace
from grind_env.plants import find_plant

METER = replace(find_plant("meter:3"), name="mine")
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a policy and a plant of one's own."""
    folder = tmp_path / "own"
    folder.mkdir()
    (folder / "my_policy.py").write_text(OWN_POLICY)
    (folder / "my_plant.py").write_text(OWN_PLANT)
    monkeypatch.syspath_prepend(folder)
    for name in ("my_policy", "my_plant"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return folder


@pytest.mark.parametrize("name", ["Mine", "MINE"])
def test_a_policy_of_ones_own_is_run_if_it_is_trusted(name: str, own: Path, submit: Submit, grind: Grind) -> None:
    path = submit("--policy", f"guarded:my_policy:{name}", episodes=6)
    shutil.rmtree(own)
    assert grind("verify", path)[0] == 0
    status, out, err = grind("verify", path, "--seed", SEED)
    assert (status, out) == (2, "") and "it runs the code of its my_policy.py: read that, and give --trust" in err
    status, out, err = grind("verify", path, "--seed", SEED, "--trust")
    assert (status, err) == (0, "") and "measured-only" in out


def test_a_plant_of_ones_own_is_run_if_it_is_trusted(own: Path, submit: Submit, grind: Grind) -> None:
    path = submit("--policy", "adaptive_rule", "--plant", "my_plant:METER", "--model", "soft:3", episodes=16)
    shutil.rmtree(own)
    for words in ((), ("--seed", SEED)):
        assert grind("verify", path, *words)[0] == 2
        status, out, err = grind("verify", path, "--trust", *words)
        assert (status, err) == (0, ""), out


CHEAT = """
import gc, sys
import numpy as np
from grind_env.policies.choices import Decision
from grind_env.envs.episodes import Episodes

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
        if self.way == "seed":  # a table of the first observations of all seeds that one may know
            rngs = [np.random.default_rng(seed) for seed in range(2_000_000, 2_000_064)]
            self.known = simulation.observe(simulation.start(rngs))

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
        if self.way == "seed" and (self.known[:, None] == observation).all(axis=2).any():
            raise RuntimeError("caught the seed")
        if self.way == "generator" and any(isinstance(each, np.random.Generator) for each in gc.get_objects()):
            raise RuntimeError("caught the generator")
        if self.way == "words" and any("SEED" in each for each in sys.argv):
            raise RuntimeError("caught the words")
        return Decision(np.full(len(observation), 7000.0), np.ones(len(observation)))
"""


@pytest.mark.parametrize("way", ["argument", "simulation", "frames", "objects", "seed", "words"])
def test_nothing_but_measurements_comes_to_a_policy_that_looks_for_more(
    way: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "my_cheat.py").write_text(CHEAT.replace("WAY", way).replace("SEED", str(SEED)))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "my_cheat", raising=False)
    monkeypatch.setattr("sys.argv", ["grind", "verify", "--seed", str(SEED)])
    cheat: Any = named_policy("my_cheat:Cheat", PLATES.simulation(), modules=True)
    # the same code beside the episodes finds what it looks for
    seeds, simulation = range(2_000_000, 2_000_004), find_problem("power_limited").simulation()
    with pytest.raises(RuntimeError, match="caught the"):
        if way == "argument":
            cheat.sees = "state"
        run_seeds(cheat, simulation, seeds)
    del cheat
    cheat = named_policy("my_cheat:Cheat", PLATES.simulation(), modules=True)
    honest = run_seeds(named_policy("E7D1", PLATES.simulation()), PLATES.simulation(), seeds)
    row = row_of(honest, PLATES, seeds, cheat, "my_cheat:Cheat")
    assert verify(row, seed=SEED, trust=True).status == "measured-only"


def test_a_policy_that_did_not_take_the_actions_is_found_out(grind: Grind, tmp_path: Path) -> None:
    better = plates_row("look_ahead", 6)
    write_row(
        tmp_path / "row.json", replace(better, policy="constant E 3 m/min, D 0", sees="measurements", says="E3D0")
    )
    assert grind("verify", tmp_path / "row.json")[0] == 0
    status, out, _ = grind("verify", tmp_path / "row.json", "--seed", SEED)
    assert status == 1 and "not measured-only: 6 other episodes cost" in out


def test_who_sees_more_or_carries_no_policy_is_only_replayed(grind: Grind, tmp_path: Path) -> None:
    for row, why in (
        (plates_row("hindsight", 2), "its policy sees the future"),
        (replace(plates_row("E7D1", 2), says=""), "its policy is not in it"),
        (row_of(FEW, PLATES, range(2), PLAIN, "agent.zip"), "its policy is not in it"),
    ):
        write_row(tmp_path / "row.json", row)
        assert grind("verify", tmp_path / "row.json")[0] == 0
        status, out, _ = grind("verify", tmp_path / "row.json", "--seed", SEED)
        assert status == 1 and f"not measured-only: {why}" in out


@pytest.mark.parametrize("name", ["cost", "good", "finished"])
def test_one_bit_of_an_episode_is_seen(name: str, grind: Grind, tmp_path: Path) -> None:
    row = plates_row("E7D1")
    other = replace(row.episodes[1], **{name: math.nextafter(getattr(row.episodes[1], name), 0.0)})
    write_row(tmp_path / "row.json", replace(row, episodes=(row.episodes[0], other, row.episodes[2])))
    status, out, err = grind("verify", tmp_path / "row.json")
    assert (status, err) == (1, "") and f"episodes[1].{name} (seed 2000001) is" in out and "comes out as" in out


@pytest.mark.parametrize("name", ["cost", "prediction", "cost_per_good_part"])
def test_a_mean_that_is_not_of_the_episodes_is_seen(name: str, grind: Grind, tmp_path: Path) -> None:
    row = plates_row("E7D1")
    for stated in ((1.0, 0.9, 1.1), *([None] if name == "cost_per_good_part" else [])):
        write_row(tmp_path / "row.json", replace(row, **{name: stated}))
        status, out, _ = grind("verify", tmp_path / "row.json")
        assert status == 1 and f"{name} is {stated}, but of its episodes it is (" in out


def test_drawn_seeds_are_those_that_the_page_says_and_none_that_anyone_trains_on() -> None:
    seeds = fresh_seeds(SEED, 200)
    for k, seed in enumerate(seeds):
        bits = int(hashlib.sha256(f"grind verify {SEED} {k}".encode()).hexdigest(), 16) >> (256 - 62)
        assert seed == 2**62 + bits
    assert len({*seeds, *fresh_seeds(SEED + 1, 200)}) == 400
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
def test_what_of_a_module_is_no_policy_is_told(name: str, said: str, own: Path) -> None:
    with pytest.raises(GrindError, match=said):
        grind_env.evaluate(name, PLATES, episodes=2)


def test_a_module_is_named_by_arguments_alone(own: Path) -> None:
    with pytest.raises(GrindError, match="there is no policy 'my_policy:Mine'"):
        named_policy("my_policy:Mine", PLATES.simulation())
    assert "my_policy" not in sys.modules
    found = grind_env.evaluate("my_policy:Mine", PLATES, episodes=2)
    assert (found.policy, found.sees, found.first_seed) == ("mine", "measurements", 2_000_000)


def test_where_other_means_lie_is_predicted() -> None:
    rng = np.random.default_rng(1)
    # of normal values as by the formula: the error of both means
    found = prediction(rng.normal(10.0, 2.0, 4000), 1000)
    half = 1.96 * 2.0 * math.sqrt(1 / 4000 + 1 / 1000)
    assert (found.high - found.low) / 2.0 == pytest.approx(half, rel=0.06)
    assert found.low < found.value < found.high
    # of values with a long tail, as costs have one, as often as it says
    draws = rng.lognormal(0.0, 0.8, (300, 2, 64))
    hits = [
        low <= others.mean() <= high
        for known, others in draws
        for _, low, high in [prediction(known, 64, resamples=400)]
    ]
    assert 0.91 < np.mean(hits) < 0.985
    assert prediction(np.full(5, 3.0), 2) == (3.0, 3.0, 3.0)
