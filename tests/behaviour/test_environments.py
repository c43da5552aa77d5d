"""Version 0 of an environment stays what it was: agents that were trained on it depend on every entry and every bit."""

import numpy as np
import pytest

from grind_env.envs.task_names import environment_id, shipped_names
from grind_env.envs.tasks import read_task
from tests.behaviour.environments import COUNT, kinds_of, recorded, vector_play
from tests.behaviour.tables import Table, Tables, additions, changes, load
from tests.envs.harness import every_id

pytestmark = pytest.mark.bits

every_environment = pytest.mark.parametrize("env_id", every_id())

SPREADS = {environment_id(name): read_task(name).spread for name in shipped_names()}

DRAWN = {
    "hidden.growth": ("lot_growth", "wheel_growth"),
    "hidden.pressure": ("lot_pressure",),
    "hidden.fracture": ("fracture_force",),
    "hidden.wear": ("g_ratio",),
    "hidden.convection": ("convection",),
    "hidden.roughness_scale": ("wheel_roughness",),
}
"""The spreads that move what is hidden; a task that has none of them keeps it at one value."""


def record_of(env_id: str) -> Tables:
    return load(env_id.removeprefix("grind/"))


def plays_of(env_id: str) -> Tables:
    kinds = kinds_of(env_id)
    return {name: rows for name, rows in record_of(env_id).items() if name in kinds}


def as_measured(rows: Table) -> Table:
    """The rows as `observation="measured"` shows them."""
    return rows[[name for name in rows.dtype.names or () if not name.startswith("hidden.")]]


def assert_as_recorded(env_id: str, was: Tables, now: Tables) -> None:
    moved = changes(was, now) + additions(was, now)  # agents depend on there being no other entry
    assert not moved, "\n".join([f"{env_id} is not what was recorded (python -m tests.behaviour.record):", *moved])


@every_environment
def test_every_form_of_an_environment_does_what_was_recorded(env_id: str) -> None:
    assert_as_recorded(env_id, record_of(env_id), recorded(env_id))


@every_environment
def test_what_is_measured_is_the_part_that_was_recorded_as_such(env_id: str) -> None:
    kinds = kinds_of(env_id)
    was = {name: as_measured(rows) for name, rows in plays_of(env_id).items()}
    now = {name: vector_play(env_id, int(was[name]["step"][-1]), observation="measured", **kinds[name]) for name in was}
    assert_as_recorded(env_id, was, now)


@every_environment
def test_the_record_goes_beyond_the_end_of_an_episode(env_id: str) -> None:
    for name, rows in plays_of(env_id).items():
        for i in range(COUNT) if name.startswith("box") else ():
            own = rows[rows["env"] == i]
            assert (own["terminated"][:-1] == 1.0).any(), name
            assert np.isnan(own["reward"][1:]).any(), name  # a reset


@every_environment
def test_everything_that_can_be_seen_or_paid_moves_in_the_record(env_id: str) -> None:
    plays = list(plays_of(env_id).values())
    names = {name for rows in plays for name in rows.dtype.names or ()}
    values = {name: {value for rows in plays if name in rows.dtype.names for value in rows[name]} for name in names}
    prefixes = ("observation.", "hidden.", "info.reward_terms.")
    still = {name for name in names if name.startswith(prefixes) and len({v for v in values[name] if v == v}) == 1}
    spread = SPREADS.get(env_id)
    constant = {name for name, drawn in DRAWN.items() if spread and not any(getattr(spread, each) for each in drawn)}
    # a wheel that stays sharp has no dress to be paid for in the end
    constant |= {"info.reward_terms.handover"} if env_id == "grind/Noise-v0" else set()
    # the diamond of a job stays as it is
    constant |= {"hidden.diamond_flat"} if env_id == "grind/Job-v0" else set()
    assert still == constant
