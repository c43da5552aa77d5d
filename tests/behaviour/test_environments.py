"""Version 0 of an environment never changes: trained agents depend on every entry and every bit."""

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

#: spreads that vary each hidden entry; without them, a task has a constant value there
DRAWN = {
    "hidden.growth": ("lot_growth", "wheel_growth"),
    "hidden.pressure": ("lot_pressure",),
    "hidden.fracture": ("fracture_force",),
    "hidden.wear": ("g_ratio",),
    "hidden.convection": ("convection",),
    "hidden.roughness_scale": ("wheel_roughness",),
    "hidden.diamond_flat": ("diamond_flat",),
    "hidden.dressed_density": ("diamond_flat",),
    "hidden.dressed_roughness": ("diamond_flat",),
}


def record_of(env_id: str) -> Tables:
    return load(env_id.removeprefix("grind/"))


def plays_of(env_id: str) -> Tables:
    kinds = kinds_of(env_id)
    return {name: rows for name, rows in record_of(env_id).items() if name in kinds}


def as_measured(rows: Table) -> Table:
    """Return the rows without hidden columns, as `observation="measured"` gives them."""
    return rows[[name for name in rows.dtype.names or () if not name.startswith("hidden.")]]


def assert_as_recorded(env_id: str, was: Tables, now: Tables) -> None:
    moved = changes(was, now) + additions(was, now)  # a new entry would break agents, too
    assert not moved, "\n".join([f"{env_id} is not what was recorded (python -m tests.behaviour.record):", *moved])


@every_environment
def test_an_environment_behaves_as_recorded_with_every_form_of_the_action(env_id: str) -> None:
    assert_as_recorded(env_id, record_of(env_id), recorded(env_id))


@every_environment
def test_measured_observations_equal_the_recorded_columns_that_are_not_hidden(env_id: str) -> None:
    kinds = kinds_of(env_id)
    was = {name: as_measured(rows) for name, rows in plays_of(env_id).items()}
    now = {name: vector_play(env_id, int(was[name]["step"][-1]), observation="measured", **kinds[name]) for name in was}
    assert_as_recorded(env_id, was, now)


@every_environment
def test_the_record_contains_the_end_of_an_episode_and_a_reset(env_id: str) -> None:
    for name, rows in plays_of(env_id).items():
        for i in range(COUNT) if name.startswith("box") else ():
            own = rows[rows["env"] == i]
            assert (own["terminated"][:-1] == 1.0).any(), name
            assert np.isnan(own["reward"][1:]).any(), name  # a reset


@every_environment
def test_every_observation_and_reward_term_varies_in_the_record(env_id: str) -> None:
    plays = list(plays_of(env_id).values())
    names = {name for rows in plays for name in rows.dtype.names or ()}
    values = {name: {value for rows in plays if name in rows.dtype.names for value in rows[name]} for name in names}
    prefixes = ("observation.", "hidden.", "info.reward_terms.")
    still = {name for name in names if name.startswith(prefixes) and len({v for v in values[name] if v == v}) == 1}
    spread = SPREADS.get(env_id)
    constant = {name for name, drawn in DRAWN.items() if spread and not any(getattr(spread, each) for each in drawn)}
    # a wheel that stays sharp has no handover cost
    constant |= {"info.reward_terms.handover"} if env_id == "grind/Noise-v0" else set()
    # the diamond of a job does not wear
    constant |= {"hidden.diamond_flat"} if env_id == "grind/Job-v0" else set()
    assert still == constant
