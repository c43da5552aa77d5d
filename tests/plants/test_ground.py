"""Machines in the compiled loops and in the interpreter. Held-out machines share one process of all families."""

from collections.abc import Iterator, Sequence
from hashlib import sha256
from itertools import count
from typing import NamedTuple

import numpy as np
import pytest

from grind_env.array_types import Array
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.cost import Outcome
from grind_env.envs.program_writer import Written
from grind_env.envs.task_gauges import noisy
from grind_env.envs.tasks import read_task
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.plants import FAMILIES, Plant, find_plant
from grind_env.plants.plant import mixed
from tests.plants.test_plant_names import differing
from tests.process.test_toy_process import NEAR, ground

CHOICES = [(6000.0, 0.0), (9000.0, 2.0), (7000.0, 0.0), (6000.0, 1.0), (8000.0, 0.0), (5000.0, 0.0)]
NEUTRAL = mixed("neutral", FAMILIES, {})


class Played(NamedTuple):
    """Results of machines side by side after the blocks of `CHOICES`; shape (machines, ...)."""

    wheels: Array
    memory: Array
    outcomes: Array
    tallies: Array
    written: Written  #: program and job of the first machine


def play(plants: Sequence[Plant]) -> Played:
    """Play one episode with one seed on each machine; the machines share their process."""
    simulation = BlockSimulation(read_task("power_limited"), process=plants[0].process, gauge=noisy(plants[0].gauge))
    episodes = simulation.start([np.random.default_rng(3) for _ in plants])
    episodes.wheels[:, OWN_FROM:] = [plant.own for plant in plants]
    blocks, outcomes, tallies = [], [], []
    for E, D in CHOICES:
        blocks.append(simulation.writer.block(episodes, 0, E, D))
        outcome, tally = simulation.step(episodes, np.full(len(plants), E), np.full(len(plants), D))
        outcomes.append(outcome)
        tallies.append(tally)
    written = simulation.writer.written(episodes, 0, blocks)
    return Played(
        episodes.wheels, episodes.memory, np.array(outcomes).swapaxes(0, 1), np.array(tallies).swapaxes(0, 1), written
    )


def held_out(*families: str) -> Plant:
    """Return the first held-out machine that has these families."""
    name = "held-out-laws" if "textbook" in families else "held-out"
    found: Iterator[Plant] = (find_plant(f"{name}:{seed}") for seed in count())
    return next(plant for plant in found if {*families} <= differing(plant))


@pytest.mark.bits
def test_neutral_numbers_change_no_bit_of_an_episode() -> None:
    ours, neutral = play([Plant(name="ours")]), play([NEUTRAL])
    assert ours.wheels[:, :OWN_FROM].tobytes() == neutral.wheels[:, :OWN_FROM].tobytes()
    for name in ("memory", "outcomes", "tallies"):
        assert getattr(ours, name).tobytes() == getattr(neutral, name).tobytes()


@pytest.mark.bits
def test_public_and_held_out_machines_grind_to_the_recorded_hash() -> None:
    halves = [play([find_plant(f"{name}:{seed}") for seed in range(8)]) for name in ("public", "held-out")]
    digest = sha256()
    tables = ((each.wheels, each.memory[:, :-1], each.outcomes, each.tallies[..., 1:]) for each in halves)
    for numbers in zip(*tables, strict=True):
        digest.update(np.concatenate(numbers).tobytes())
    assert digest.hexdigest()[:16] == "2082d8f48b20bb7a"


@pytest.mark.bits
def test_machines_of_a_batch_grind_as_alone_bit_for_bit() -> None:
    plants = [find_plant(f"held-out:{seed}") for seed in range(11)]
    together = play(plants)
    for i in (0, 4, 10):
        alone = play([plants[i]])
        for name in ("wheels", "memory", "outcomes", "tallies"):
            assert getattr(alone, name)[0].tobytes() == getattr(together, name)[i].tobytes()
    costs = together.outcomes[..., Outcome._fields.index("cost")].sum(axis=1)
    assert len({*costs.tolist()}) == len(plants)
    assert np.isfinite(together.outcomes).all()


@pytest.mark.parametrize(
    "families", [("foreign", "drift"), ("bursts", "table"), ("thermal", "graded"), ("textbook", "table")]
)
def test_the_interpreter_grinds_the_program_of_an_episode_as_the_environment(families: tuple[str, ...]) -> None:
    plant = held_out(*families)
    played = play([plant])
    assert played.written.job.process == plant.process
    assert played.written.job.own == plant.of_process
    run = ground(played.written)
    assert run.wheel is not None
    found = played.wheels[0, : OWN_FROM + len(plant.of_process)]
    np.testing.assert_allclose([*run.wheel, *run.mount.own[0]], found, rtol=NEAR, atol=1e-12)
    strokes = run.record().strokes
    assert len(strokes) == played.tallies[0, :, Tally._fields.index("strokes")].sum()
    seconds = played.outcomes[0, :, Outcome._fields.index("seconds")].sum()
    assert run.record().seconds == pytest.approx(seconds, rel=1e-9)
