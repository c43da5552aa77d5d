"""Shifts on a machine: memory between shifts, information for the policy, and costs."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from grind_env.envs.cost import Outcome
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.kernel.random import philox
from grind_env.plants import find_plant
from grind_env.plants.drift import MOST_DULLING
from grind_env.plants.event_random import deviate
from grind_env.policies import track
from grind_env.policies.choices import Decision
from grind_env.policies.policy import Sees
from grind_env.policies.registry import make_policy
from grind_env.policies.scripted.rules import Fixed
from grind_env.policies.track import TrackMachine, TrackShift, books, run_shifts
from grind_env.process.process_interface import PROCESS

DRIFTING = "public:4"  #: machine that drifts and warms up


class Slower:
    """Policy that slows down after every shift and keeps everything it is given."""

    name = "slower"
    sees: Sees = "measurements"

    def __init__(self) -> None:
        self.E, self.given, self.calls = 7000.0, list[Any](), list[str]()

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.given.append(simulation)
        self.calls.append("begin")

    def act(self, observation: np.ndarray, episodes: Episodes | None) -> Decision:
        self.given += [observation, episodes]
        return Decision(np.full(len(observation), self.E), np.ones(len(observation)))

    def learn(self, shift: TrackShift) -> None:
        self.given.append(shift)
        self.calls.append("learn")
        self.E -= 500.0


def remembered(plant: str, own: Sequence[float]) -> dict[str, float]:
    return dict(zip(find_plant(plant).remembers._fields, own, strict=True))


def test_a_machine_takes_its_memory_but_no_shift_state_to_the_next_shift() -> None:
    plant = find_plant(DRIFTING)
    own = [x + 0.25 for x in plant.own]
    first, second = (remembered(DRIFTING, plant.after(tuple(own), number).own) for number in (1, 2))
    begun = remembered(DRIFTING, plant.own)
    anew = {*PROCESS.own._fields, "bursts_owed", "thermal_grown", "drift_idle"}
    chances = {name for name in begun if name.endswith("_seed")}
    assert {name for name in begun if first[name] == begun[name]} == anew
    assert {name for name in begun if first[name] == begun[name] + 0.25} == begun.keys() - anew - chances
    assert {name for name in begun if first[name] != second[name]} == chances and len(chances) == 3


def test_a_drift_continues_in_the_next_shift_with_new_steps() -> None:
    machine, dulling = TrackMachine(DRIFTING, [0]), 0.0
    numbers = remembered(DRIFTING, machine.first.own)
    assert numbers["drift_dulls"] > 0.0
    for number in range(2):
        machine.grind(Fixed(E=7000.0, D=1))
        now = remembered(DRIFTING, machine.remembers[0])
        for block in range(60):
            dulling += numbers["drift_dulls"] * deviate(philox(int(now["drift_seed"]), 0, block, 0, 0, 0)[0])
            dulling = min(max(dulling, -MOST_DULLING), MOST_DULLING)
        assert now["drift_dulling"] == pytest.approx(dulling, rel=1e-12), number


def test_lots_depend_only_on_seed_and_machine() -> None:
    (slow,), alone = TrackMachine(DRIFTING, [3]).grind(Fixed(E=5000.0, D=1))
    machine = TrackMachine(DRIFTING, [2, 3])
    fast, _ = machine.grind(Fixed(E=9000.0, D=1))
    (other,), _ = TrackMachine("public:5", [3]).grind(Fixed(E=5000.0, D=1))
    stock = [machine.model.read(each.observations)["stock"] for each in (slow, fast[1], fast[0], other)]
    np.testing.assert_array_equal(*stock[:2])
    assert not (stock[0] == stock[2]).all() and not (stock[0] == stock[3]).all()
    _, beside = TrackMachine(DRIFTING, [2, 3]).grind(Fixed(E=5000.0, D=1))
    assert beside.cost[1] == alone.cost[0] != beside.cost[0] and alone.parts.tolist() == [[60.0]]


def test_books_charge_scrap_by_whole_parts_and_leave_out_the_handover() -> None:
    names = Outcome._fields
    rows = np.zeros((3, len(names)))
    rows[:, names.index("cost")] = (5.0, 12.0 + 15.0, 8.0 + 2.0)
    rows[:, names.index("scrap_cost")] = (0.0, 15.0, 0.0)
    rows[:, names.index("handover_cost")] = (0.0, 0.0, 2.0)
    rows[:, names.index("finished")] = (0.0, 1.0, 1.0)
    rows[:, names.index("good")] = (0.0, 0.75, 1.0)
    costs = {bool(bad[1]): cost.tolist() for bad, cost in (books(rows, np.random.default_rng(k)) for k in range(40))}
    assert costs == {False: [5.0, 12.0, 8.0], True: [5.0, 72.0, 8.0]}
    shares = [books(np.tile(rows[1], (1000, 1)), np.random.default_rng(k))[0].mean() for k in range(10)]
    assert np.mean(shares) == pytest.approx(0.25, abs=0.02)


def numbers_in(thing: Any, seen: set[int], found: set[float]) -> None:
    """Add to `found` all numbers that can be reached from a thing."""
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


def test_a_learner_gets_the_log_of_every_shift_and_only_measurements(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(track, "SHIFTS", 2)
    policy = Slower()
    came = run_shifts(policy, DRIFTING, [0])
    assert policy.calls == ["begin", "learn"] * 2 and came.cost.shape == (1, 2)
    logs = [each for each in policy.given if isinstance(each, TrackShift)]
    assert [[*{*each.speeds}] for each in logs] == [[7000.0], [6500.0]] and logs[0].observations.shape[0] == 61
    machine = TrackMachine(DRIFTING, [0])
    for shift, E in enumerate((7000.0, 6500.0)):
        assert machine.grind(Fixed(E=E, D=1))[1].cost[0, 0] == came.cost[0, shift]
    reached: set[float] = set()
    numbers_in(policy.given, {id(None)}, reached)
    usual = {*machine.first.remembers()}
    drawn = {x for x in (*machine.first.own, *machine.remembers[0]) if x not in usual}
    assert len(reached) > 1000 and len(drawn) > 5
    assert not drawn & reached and not any(isinstance(each, Episodes) for each in policy.given)


def test_the_track_refuses_a_policy_with_privileged_information() -> None:
    with pytest.raises(GrindError, match="hindsight sees the future, but on the track there are measurements alone"):
        run_shifts(make_policy("hindsight", TrackMachine(DRIFTING, [0]).model), DRIFTING, [0])
