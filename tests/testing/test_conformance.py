"""The conformance checker passes good vector environments, and every check of it catches a fault of its own."""

from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from tests.envs import faulty_walks as faulty
from tests.envs.harness import native
from tests.envs.walks import Walk, Walks
from tests.testing.conformance import CHECKS, VectorConformanceError, check_vector_env
from tests.testing.conformance_play import outside


def check(make: Callable[[AutoresetMode], Any], **options: Any) -> None:
    check_vector_env(make, steps=30, **options)


def test_a_good_environment_passes() -> None:
    check(Walks)
    check(Walks, single=Walk)


@pytest.mark.parametrize(
    ("env_id", "strict"),
    [("CartPole-v1", True), ("MountainCar-v0", True), ("Acrobot-v1", True), ("Pendulum-v1", False)],
)
def test_sync_vector_envs_of_classic_control_pass(env_id: str, strict: bool) -> None:
    def single() -> Any:
        return gym.make(env_id, max_episode_steps=14)

    check(lambda mode: SyncVectorEnv([single] * 3, autoreset_mode=mode), single=single, strict_actions=strict)


def test_the_native_cart_pole_passes_without_seeds_of_its_own_for_each() -> None:
    def make(mode: AutoresetMode) -> Any:
        return gym.make_vec("CartPole-v1", 3)

    check_vector_env(make, modes=[AutoresetMode.NEXT_STEP], seeds_each=False)
    with pytest.raises(VectorConformanceError, match="autoreset_mode"):
        check_vector_env(make, modes=[AutoresetMode.SAME_STEP], seeds_each=False)


@pytest.mark.parametrize("env_id", ["grind/Oracle6-v0", "grind/PowerLimited-v0"])
@pytest.mark.parametrize("show_block", [False, True])
def test_the_grinding_environments_pass(env_id: str, show_block: bool) -> None:
    blocks = gym.make(env_id).unwrapped.task.blocks
    check_vector_env(
        lambda mode: native(env_id, 3, mode, show_block=show_block),
        single=lambda: gym.make(env_id, show_block=show_block),
        steps=2 * blocks + 3,
    )


def test_buffers_may_be_handed_out_only_if_that_is_declared() -> None:
    def make(mode: AutoresetMode) -> Any:
        return SyncVectorEnv([Walk] * 3, copy=False, autoreset_mode=mode)

    check(make, copies=False)
    with pytest.raises(VectorConformanceError, match="after later calls"):
        check(make)


def test_actions_may_be_clipped_only_if_that_is_declared() -> None:
    check(faulty.ClipsActions, strict_actions=False)
    with pytest.raises(VectorConformanceError, match="takes actions with"):
        check(faulty.ClipsActions)


def test_nan_is_outside_of_every_box_of_floats() -> None:
    for high in (1.0, np.inf):
        nan, infinite = outside(spaces.Box(-high, high, (2,), np.float32))
        assert np.isnan(nan) and infinite == np.inf
    assert outside(spaces.Box(0, 5, (2,), np.int64)) == []


FAULTS: dict[str, dict[type[Walks], str]] = {
    "check_spaces": {
        faulty.NotBatched: "must be batch_space",
        faulty.OtherSpace: "but the single environment has",
    },
    "check_metadata": {faulty.SharedMetadata: "set it on the instance"},
    "check_results": {
        faulty.BeyondBounds: "not in observation_space",
        faulty.ColumnOfRewards: "float array of shape",
        faulty.FlagsAsNumbers: "truncations of .* bool array",
        faulty.NoMask: "needs a mask",
        faulty.LeakyMask: "must be None",
    },
    "check_seeds": {
        faulty.SeedTimesTwo: "with seed 0 and with 0, 1",
        faulty.SharedSeeds: "other seeds beside it",
    },
    "check_reproducible": {
        faulty.NoisyActions: "the same seed and plan",
    },
    "check_autoreset": {
        faulty.StepsOnReset: "must ignore the action",
        faulty.NoFinalObs: "must come with .*final_obs",
    },
    "check_modes_agree": {
        faulty.ResetsTwice: "here and in autoreset mode",
        faulty.FinalObsIsTheNextFirst: "here and in autoreset mode",
    },
    "check_reset_mask": {
        faulty.MaskWithoutSeed: "seeded first observation",
        faulty.IgnoresMaskWithAutoreset: "the one before the reset, whose mask leaves it out,",
    },
    "check_reset_after_end": {
        faulty.StaysDue: "at the start and after an end",
    },
    "check_ownership": {
        faulty.HandsOutItsState: "after later calls",
    },
    "check_actions": {
        faulty.ClipsInPlace: "actions before and after",
        faulty.ClipsActions: "takes actions with",
    },
    "check_close": {faulty.ClosesOnce: "called again"},
    "check_parity": {
        faulty.OtherDynamics: "SyncVectorEnv",
    },
}


@pytest.mark.parametrize(
    ("name", "fault", "sentence"),
    [(name, fault, sentence) for name, faults in FAULTS.items() for fault, sentence in faults.items()],
)
def test_every_fault_is_caught_by_its_check(name: str, fault: type[Walks], sentence: str) -> None:
    # without the single environment beside it where possible: parity alone would catch most of them
    single = Walk if name in ("check_spaces", "check_parity") else None
    with pytest.raises(VectorConformanceError, match=sentence) as caught:
        check(fault, single=single)
    assert str(caught.value).startswith("in autoreset mode ") and "\n" not in str(caught.value)
    assert name in [entry.name for entry in caught.traceback]


def test_every_check_has_a_fault_to_catch() -> None:
    assert [check.__name__ for check in CHECKS] == list(FAULTS)


def test_an_environment_that_ends_no_episode_is_named() -> None:
    with pytest.raises(VectorConformanceError, match="ended no episode within 1 steps"):
        check_vector_env(Walks, steps=1)


def test_something_else_than_a_vector_env_is_refused() -> None:
    with pytest.raises(VectorConformanceError, match="Walk is no VectorEnv"):
        check_vector_env(lambda mode: Walk())
