"""The track of machines that are not the model: what is carried, what is shown, what is counted, what it is worth."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.track import knowing
from agents.track.adapters import made
from agents.track.floor import TrackMachine, found
from agents.track.knowing import FIXED, PLANNER
from agents.track.page import page, tables_of
from agents.track.running import TrackRun, TrackTrial, run
from agents.track.scores import beaten, machine_scores, resampled, scored, worst_of
from grind_env.envs.cost import Outcome
from grind_env.envs.episodes import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.kernel.random import philox
from grind_env.machine.loops.rows import OWN_FROM
from grind_env.plants import find_plant
from grind_env.plants.chance import deviate
from grind_env.plants.drift import MOST_DULLING
from grind_env.policies.choices import Decision
from grind_env.policies.naming import named_policy
from grind_env.policies.problem import find_problem
from grind_env.process.process import PartHeat
from tests.agents.asking import in_process, status

PLATES = find_problem("power_limited")
DRIFTING = "public:4"
"""It wanders, and warms up."""
OWN = """
from grind_env.policies.naming import own_policy
from grind_env.policies.scripted.rules import Fixed

class Mine:
    name = "mine"
    def start(self, problem):
        self.shifts = []
        return Fixed(E=7000.0, D=1)
    def learn(self, shift):
        self.shifts.append(shift)
        return Fixed(E=7000.0 - 500.0 * len(self.shifts), D=1)

class Seer(Fixed):
    sees = "state"

class Cheat(Mine):
    name = "cheat"
    def learn(self, shift):
        return Seer(E=7000.0, D=1)
"""


class Collector:
    """Keeps whatever it is given."""

    name, sees = "collector", "measurements"

    def __init__(self) -> None:
        self.given: list[Any] = []

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.given.append(simulation)

    def act(self, observation: np.ndarray, episodes: Episodes | None) -> Decision:
        self.given += [observation, episodes]
        n = len(observation)
        return Decision(np.full(n, 7000.0), np.ones(n))


def remembered(plant: str, own: Sequence[float]) -> dict[str, float]:
    return dict(zip(find_plant(plant).remembers._fields, own, strict=True))


def test_what_a_machine_remembers_goes_from_shift_to_shift_and_what_is_of_a_shift_does_not() -> None:
    plant = find_plant(DRIFTING)
    own = [x + 0.25 for x in plant.own]
    first, second = (remembered(DRIFTING, plant.after(tuple(own), number).own) for number in (1, 2))
    begun = remembered(DRIFTING, plant.own)
    anew = {*PartHeat._fields, "bursts_owed", "thermal_grown", "drift_idle"}
    chances = {name for name in begun if name.endswith("_seed")}
    assert {name for name in begun if first[name] == begun[name]} == anew
    assert {name for name in begun if first[name] == begun[name] + 0.25} == begun.keys() - anew - chances
    assert {name for name in begun if first[name] != second[name]} == chances and len(chances) == 3


def test_a_walk_goes_on_where_it_was_with_other_steps() -> None:
    floor, policy = TrackMachine(PLATES, DRIFTING, 0), named_policy("E7000D1", TrackMachine(PLATES, DRIFTING, 0).model)
    numbers = remembered(DRIFTING, floor.first.own)
    assert numbers["drift_dulls"] > 0.0
    dulling = 0.0
    for number in range(2):
        floor.grind(policy)
        seed = int(remembered(DRIFTING, floor.remembers)["drift_seed"])
        for block in range(60):
            word = philox(seed, 0, block, 0, 0, 0)[0]
            dulling += numbers["drift_dulls"] * deviate(word)
            dulling = min(max(dulling, -MOST_DULLING), MOST_DULLING)
        assert remembered(DRIFTING, floor.remembers)["drift_dulling"] == pytest.approx(dulling, rel=1e-12), number
    begun = floor._begun([1, 2, 3])
    at = floor.first.remembers._fields.index("drift_dulling")
    assert (begun.wheels[:, OWN_FROM + at] == remembered(DRIFTING, floor.remembers)["drift_dulling"]).all()
    assert len({*begun.wheels[:, OWN_FROM + floor.first.remembers._fields.index("drift_seed")]}) == 3


def test_lots_are_those_of_the_seed_whatever_is_done() -> None:
    slow, fast = (TrackMachine(PLATES, DRIFTING, 3) for _ in range(2))
    one, other = slow.grind(named_policy("E5000D1", slow.model)), fast.grind(named_policy("E9000D1", fast.model))
    stock = [slow.model.read(each.shift.observations)["stock"] for each in (one, other)]
    np.testing.assert_array_equal(*stock)
    assert one.cost != other.cost and slow.grind(named_policy("E5000D1", slow.model)).cost != one.cost


def test_books_are_what_is_paid_but_for_what_nobody_measures() -> None:
    names = Outcome._fields
    rows = np.zeros((3, len(names)))
    rows[:, names.index("cost")] = (5.0, 12.0 + 15.0, 8.0 + 2.0)
    rows[:, names.index("scrap_cost")] = (0.0, 15.0, 0.0)
    rows[:, names.index("handover_cost")] = (0.0, 0.0, 2.0)
    rows[:, names.index("finished")] = (0.0, 1.0, 1.0)
    rows[:, names.index("good")] = (0.0, 0.75, 1.0)
    costs = {bool(bad[1]): cost.tolist() for bad, cost in (found(rows, np.random.default_rng(k)) for k in range(40))}
    assert costs == {False: [5.0, 12.0, 8.0], True: [5.0, 72.0, 8.0]}
    shares = [found(np.tile(rows[1], (1000, 1)), np.random.default_rng(k))[0].mean() for k in range(10)]
    assert np.mean(shares) == pytest.approx(0.25, abs=0.02)


def numbers_in(thing: Any, seen: set[int], found: set[float]) -> None:
    """All numbers that can be reached from a thing."""
    if id(thing) in seen or isinstance(thing, str | bytes | type | Callable):
        return
    seen.add(id(thing))
    if isinstance(thing, np.ndarray):
        found.update(np.asarray(thing, np.float64).ravel().tolist())
    elif isinstance(thing, int | float):
        found.add(float(thing))
    else:
        inner = thing.values() if isinstance(thing, dict) else thing if isinstance(thing, list | tuple | set) else ()
        for each in (*inner, *vars(thing).values()) if hasattr(thing, "__dict__") else inner:
            numbers_in(each, seen, found)
        for name in getattr(type(thing), "__slots__", ()):
            numbers_in(getattr(thing, name, None), seen, found)


def test_nothing_but_measurements_reaches_an_adapter() -> None:
    floor, policy = TrackMachine(PLATES, DRIFTING, 0), Collector()
    ground = floor.grind(policy)
    floor.judge(policy, 2)
    reached: set[float] = set()
    numbers_in([policy.given, ground.shift, PLATES], {id(None)}, reached)
    usual = {*floor.first.remembers()}
    drawn = {x for x in (*floor.first.own, *floor.remembers) if x not in usual}
    assert len(reached) > 1000 and len(drawn) > 5
    assert not drawn & reached
    assert not any(isinstance(each, Episodes) for each in policy.given)


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Name of a module with adapters of one's own."""
    (tmp_path / "my_adapters.py").write_text(OWN)
    monkeypatch.syspath_prepend(tmp_path)
    return "my_adapters"


def test_an_adapter_that_would_see_more_is_refused(module: str) -> None:
    cell = TrackTrial(PLATES, DRIFTING, f"{module}:Cheat", 0, (0, 60))
    with pytest.raises(GrindError, match="sees the state, but on the track there are measurements alone"):
        run(cell)
    with pytest.raises(GrindError, match="full_state_rule sees the state"):
        run(replace(cell, adapter="full_state_rule"))


def test_a_run_is_judged_with_what_was_learned(module: str) -> None:
    done = run(TrackTrial(PLATES, DRIFTING, f"{module}:Mine", 0, (0, 60, 120)))
    assert len(done.costs) == 2 and [*done.judged] == ["0", "60", "120"]
    floor = TrackMachine(PLATES, DRIFTING, 0)
    for E in (7000, 6500):
        floor.grind(named_policy(f"E{E}D1", floor.model))
    assert done.judged["120"][0] == floor.judge(named_policy("E6000D1", floor.model), 64).cost.tolist()


def test_scores_are_between_the_anchors_and_intervals_over_machines() -> None:
    def of(cost: Sequence[float]) -> TrackRun:
        return TrackRun(
            costs=[100.0, 90.0], scrap=[1.5, 0.0], parts=[60.0, 60.0], judged={"120": [[*cost], [9.0] * 4, [10.0] * 4]}
        )

    found = {}
    for k, plant in enumerate(("public:1", "public:2")):
        for seed in range(2):
            for name, cost in ((FIXED, 200.0), (PLANNER, 100.0), ("mine", 150.0 + 40.0 * k)):
                found[TrackTrial(PLATES, plant, name, seed, (120,))] = of(cost + 10.0 * np.array([-1.0, 0.0, 0.0, 1.0]))
    fixed, planner, mine = scored(found)
    assert fixed.score == (0.0, 0.0, 0.0) and planner.score == (100.0, 100.0, 100.0)
    assert mine.score.value == pytest.approx(30.0) and mine.worst.value == pytest.approx(10.0)
    assert mine.median == pytest.approx(30.0) and (mine.better, planner.better, fixed.better) == (2, 2, 0)
    assert mine.score.low == pytest.approx(10.0, abs=5.0) and mine.score.high == pytest.approx(50.0, abs=5.0)
    assert mine.scrap == pytest.approx(0.1) and mine.learning_scrap == pytest.approx(1.5 / 120.0)
    assert (mine.violations, mine.runs) == (4, 4) and mine.spent == 1.0 and mine.beaten == math.inf


@pytest.mark.nightly
def test_adapters_stand_beside_others_on_the_same_machines_alone() -> None:
    def of(cost: float) -> TrackRun:
        return TrackRun(costs=[100.0], scrap=[0.0], parts=[60.0], judged={"60": [[cost], [10.0], [10.0]]})

    found = {
        TrackTrial(PLATES, f"public:{k}", name, 0, (60,)): of(cost * k)
        for name, cost, machines in ((FIXED, 200.0, 3), (PLANNER, 100.0, 3), ("robust", 150.0, 3), ("trim", 120.0, 2))
        for k in range(1, machines + 1)
    }
    tables = tables_of(found)
    assert [*tables] == ["power_limited, 3 machines", "power_limited, 2 machines"]
    whole, few = ({row.adapter: row for row in scored(runs)} for runs in tables.values())
    assert [*whole] == [FIXED, PLANNER, "robust"] and [*few] == [FIXED, PLANNER, "robust", "trim"]
    assert {row.machines for row in whole.values()} == {3} and {row.machines for row in few.values()} == {2}
    assert few["trim"].score.value == pytest.approx(80.0) and few["robust"].score.value == pytest.approx(50.0)
    assert page(found).count("| robust |") == 2 and page(found).count("| trim |") == 1


def test_by_hand() -> None:
    assert beaten([3.0, 1.0, 1.0], [2.0, 2.0, 2.0]) == 3.0  # saved: -1, 0, 1
    assert beaten([1.0, 1.0], [2.0, 2.0]) == 1.0 and beaten([1.0, 4.0], [2.0, 2.0]) == math.inf
    assert worst_of(np.arange(20.0)) == 0.5 and worst_of(np.array([[3.0, 1.0], [2.0, 5.0]])).tolist() == [1.0, 2.0]
    costs = np.random.default_rng(0).normal([[[[110.0]]], [[[120.0]]], [[[100.0]]]], 1.0, (3, 5, 3, 40))
    draws = resampled(costs).mean(axis=1)
    assert machine_scores(costs).mean() == pytest.approx(50.0, abs=2.0)
    # episodes, seeds and machines scatter by chance alone: as the mean over all of them
    assert 0.5 < draws.std() / (100.0 / 20.0 * 1.2 / math.sqrt(600.0)) < 2.0


@pytest.mark.nightly
def test_the_command_runs_the_track(module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    for name, number in (("EVALUATIONS", 4), ("STARTS", 1), ("EPISODES", 2)):
        monkeypatch.setattr(knowing, name, number)
    in_process(monkeypatch)
    words = ["track", "--machines", "public:1", "--adapters", "E7000D1", "--adapters", f"{module}:Mine", "--seeds", "1"]
    assert status(monkeypatch, *words, "--blocks", "60,0", "--episodes", "2", "--cache", tmp_path) == 0
    said = capsys.readouterr().out
    assert "1 runs, 1 to do: about 0.0 core-hours" in said and "4 runs, 4 to do: about 0.0 core-hours" in said
    rows = (tmp_path / "track.csv").read_text().splitlines()
    assert len(rows) == 1 + 4 * 2 and rows[0].startswith("task,plant,adapter,seed,blocks,cost")
    assert f"| {FIXED} | 0 | 0 (0 to 0) |" in (tmp_path / "track.md").read_text()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--blocks", "0,61"], "--blocks has '61', but a shift of power_limited has 60: give multiples"),
        (["--machines", "public"], "'public' is the name of many machines: give a seed, as 'public:1'"),
        (["--adapters", "nobody"], "there is no policy 'nobody'"),
        (["--adapters", "no_module:Mine"], "'no_module:Mine' names no policy"),
    ],
)
def test_what_the_track_does_not_have_is_told(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    assert status(monkeypatch, "track", "--cache", tmp_path, *words) == 2 and said in capsys.readouterr().err


def test_adapters_by_name(module: str) -> None:
    assert made("guarded:look_ahead").name == "guarded:look_ahead"
    assert made(f"{module}:Mine").name == "mine"
    policy = made("plain_gru").start(PLATES)
    assert policy.name == "plain_gru" and "Actor(" in repr(policy)
