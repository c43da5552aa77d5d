"""The conformance checker passes good vector environments, and every check of it catches a fault of its own."""

from collections.abc import Callable
from typing import Any, ClassVar

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.vector.utils import batch_space

from grind_env.envs.conformance import CHECKS, VectorConformanceError, check_vector_env
from grind_env.envs.wen import WenEnv, WenVectorEnv
from tests.envs.harness import Array, native
from tests.envs.walks import Walk, Walks


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


def test_the_wen_environment_passes() -> None:
    check_vector_env(lambda mode: WenVectorEnv(3, mode), single=WenEnv, steps=12)


def test_buffers_may_be_handed_out_only_if_that_is_declared() -> None:
    def make(mode: AutoresetMode) -> Any:
        return SyncVectorEnv([Walk] * 3, copy=False, autoreset_mode=mode)

    check(make, copies=False)
    with pytest.raises(VectorConformanceError, match="after later calls"):
        check(make)


def test_actions_may_be_clipped_only_if_that_is_declared() -> None:
    check(ClipsActions, strict_actions=False)
    with pytest.raises(VectorConformanceError, match="takes actions with"):
        check(ClipsActions)


# --- one fault each ------------------------------------------------------------------------------------------


class NotBatched(Walks):
    def __init__(self, mode: AutoresetMode) -> None:
        super().__init__(mode)
        self.observation_space = batch_space(self.single_observation_space, 4)


class OneAlone(Walks):
    def __init__(self, mode: AutoresetMode) -> None:
        super().__init__(mode)
        self.num_envs = 1


class OtherSpace(Walks):
    def __init__(self, mode: AutoresetMode) -> None:
        super().__init__(mode)
        self.single_action_space = spaces.Box(-2.0, 2.0, (1,), np.float32)
        self.action_space = batch_space(self.single_action_space, 3)


class ModeAsText(Walks):
    def __init__(self, mode: AutoresetMode) -> None:
        super().__init__(mode)
        self.metadata = {"autoreset_mode": mode.value}


class SharedMetadata(Walks):
    SHARED: ClassVar[dict[str, Any]] = {}

    def __init__(self, mode: AutoresetMode) -> None:
        super().__init__(mode)
        self.SHARED["autoreset_mode"] = mode
        self.metadata = self.SHARED


class IgnoresSeed(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return super().reset(options=options)


class FreshEntropy(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        seeds = np.random.default_rng().integers(1000, size=3).tolist() if seed is None and options is None else seed
        return super().reset(seed=seeds, options=options)


class SeedTimesTwo(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return super().reset(seed=[seed + 2 * i for i in range(3)] if isinstance(seed, int) else seed, options=options)


class SharedSeeds(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        seeds = [each + sum(seed) - 3 * seed[0] - 3 for each in seed] if isinstance(seed, list) else seed
        return super().reset(seed=seeds, options=options)


class AnyNumberOfSeeds(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return super().reset(seed=seed[:3] if isinstance(seed, list) else seed, options=options)


class WideObservations(Walks):
    def step(self, actions: Array) -> Any:
        observations, *rest = super().step(actions)
        return observations.astype(np.float64), *rest


class BeyondBounds(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        observations, info = super().reset(seed=seed, options=options)
        return observations + np.float32(30.0), info


class FourResults(Walks):
    def step(self, actions: Array) -> Any:
        observations, rewards, terminations, truncations, info = super().step(actions)
        return observations, rewards, terminations | truncations, info


class ColumnOfRewards(Walks):
    def step(self, actions: Array) -> Any:
        observations, rewards, *rest = super().step(actions)
        return observations, rewards[:, None], *rest


class WholeRewards(Walks):
    def step(self, actions: Array) -> Any:
        observations, rewards, *rest = super().step(actions)
        return observations, rewards.astype(int), *rest


class NoNumber(Walks):
    def step(self, actions: Array) -> Any:
        observations, rewards, *rest = super().step(actions)
        return observations, rewards * np.nan, *rest


class FlagsAsNumbers(Walks):
    def step(self, actions: Array) -> Any:
        *before, truncations, info = super().step(actions)
        return *before, truncations.astype(float), info


class ListOfInfos(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        return *before, [info]


class NoMask(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        info.pop("_place", None)
        return *before, info


class MaskAsNumbers(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        observations, info = super().reset(seed=seed, options=options)
        return observations, {**info, "_goal": info["_goal"].astype(int)}


class ShortInfo(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        if "parts" in info:
            info["parts"]["step"] = info["parts"]["step"][:2]
        return *before, info


class OneForAll(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        return *before, {**info, "place": 0.5}


class LeakyMask(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        if "name" in info:
            info["name"][:] = "step"
        return *before, info


class NoisyActions(Walks):
    def step(self, actions: Array) -> Any:
        return super().step(actions * np.random.default_rng().uniform(0.9, 1.0, actions.shape).astype(np.float32))


class NoisyRewards(Walks):
    def step(self, actions: Array) -> Any:
        observations, rewards, *rest = super().step(actions)
        return observations, rewards - np.random.default_rng().random(3) * (rewards != 0.0), *rest


class StepsOnReset(Walks):
    """In NEXT_STEP mode the first action of an episode is taken with the reset."""

    def step(self, actions: Array) -> Any:
        over = self.over.copy()
        _, *rest = super().step(actions)
        for i in np.flatnonzero(over & (self.mode is AutoresetMode.NEXT_STEP)):
            self.observations[i] = self.walks[i].step(actions[i])[0]
        return self.observations.copy(), *rest


class RewardOnReset(Walks):
    def step(self, actions: Array) -> Any:
        over = self.over.copy()
        observations, rewards, *rest = super().step(actions)
        return observations, np.where(over, -0.1, rewards), *rest


class NoFinalObs(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        info.pop("final_obs", None)
        info.pop("_final_obs", None)
        return *before, info


class FinalMaskTooWide(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        if "_final_info" in info:
            info["_final_info"][:] = True
        return *before, info


class FinalObsOfAnotherShape(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        for i in np.flatnonzero(info.get("_final_obs", np.zeros(3, bool))):
            info["final_obs"][i] = info["final_obs"][i][:1]
        return *before, info


class FinalObsIsTheNextFirst(Walks):
    def step(self, actions: Array) -> Any:
        observations, *between, info = super().step(actions)
        for i in np.flatnonzero(info.get("_final_obs", np.zeros(3, bool))):
            info["final_obs"][i] = observations[i].copy()
        return observations, *between, info


class ResetsTwice(Walks):
    """In NEXT_STEP mode an episode is thrown away with every end."""

    def step(self, actions: Array) -> Any:
        over = self.over.copy()
        _, *rest = super().step(actions)
        for i in np.flatnonzero(over & (self.mode is AutoresetMode.NEXT_STEP)):
            self.observations[i] = self.walks[i].reset()[0]
        return self.observations.copy(), *rest


class IgnoresMask(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return super().reset(seed=seed)


class MaskWithoutSeed(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return super().reset(seed=None if options else seed, options=options)


class MarksAll(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        observations, info = super().reset(seed=seed, options=options)
        return observations, {**info, "_goal": np.ones(3, bool)}


class HandsOutItsState(Walks):
    def step(self, actions: Array) -> Any:
        return self.observations, *super().step(actions)[1:]


class HandsOutAConstant(Walks):
    def __init__(self, mode: AutoresetMode) -> None:
        super().__init__(mode)
        self.constant = np.zeros(3)

    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        return *before, {**info, "constant": self.constant, "_constant": np.ones(3, bool)}


class ClipsInPlace(Walks):
    def step(self, actions: Array) -> Any:
        result = super().step(actions)
        actions *= 0.5
        return result


class TakesAnyNumber(Walks):
    def step(self, actions: Array) -> Any:
        return super().step(np.resize(actions, (3, 1)))


class ClipsActions(Walks):
    def step(self, actions: Array) -> Any:
        return super().step(np.nan_to_num(actions, nan=0.0).clip(-1.0, 1.0))


class ClosesOnce(Walks):
    def close(self, **kwargs: Any) -> None:
        del self.walks


class OtherDynamics(Walks):
    def step(self, actions: Array) -> Any:
        return super().step(0.999 * actions)


class OneInfoMore(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        return *before, {**info, "age": np.zeros(3), "_age": np.ones(3, bool)}


FAULTS: dict[str, dict[type[Walks], str]] = {
    "check_spaces": {
        NotBatched: "must be batch_space",
        OneAlone: "must be 2 or more",
        OtherSpace: "but the single environment has",
    },
    "check_metadata": {ModeAsText: "set it on the instance", SharedMetadata: "set it on the instance"},
    "check_results": {
        WideObservations: "not in observation_space",
        BeyondBounds: "not in observation_space",
        FourResults: "tuple of 5",
        ColumnOfRewards: "float array of shape",
        WholeRewards: "float array of shape",
        NoNumber: "must be finite",
        FlagsAsNumbers: "truncations of .* bool array",
        ListOfInfos: "must be a dict",
        NoMask: "needs a mask",
        MaskAsNumbers: "needs a mask",
        ShortInfo: "within .*parts.* 3 entries",
        OneForAll: "place.* array with 3 entries",
        LeakyMask: "must be None",
    },
    "check_seeds": {
        IgnoresSeed: r"two results of reset\(seed=0\)",
        FreshEntropy: r"two results of reset\(\)",
        SeedTimesTwo: "with seed 0 and with 0, 1",
        SharedSeeds: "other seeds beside it",
        AnyNumberOfSeeds: "takes 4 seeds",
    },
    "check_reproducible": {NoisyActions: "the same seed and plan", NoisyRewards: "the same seed and plan"},
    "check_autoreset": {
        StepsOnReset: "must ignore the action",
        RewardOnReset: "reward 0 and no flags",
        NoFinalObs: "must come with .*final_obs",
        FinalMaskTooWide: "must come with .*final_info",
        FinalObsOfAnotherShape: "not in single_observation_space",
        IgnoresMask: "whose mask leaves it out",
    },
    "check_modes_agree": {
        ResetsTwice: "here and in autoreset mode",
        FinalObsIsTheNextFirst: "here and in autoreset mode",
    },
    "check_reset_mask": {MaskWithoutSeed: "seeded first observation", MarksAll: "marks sub-environments"},
    "check_ownership": {
        HandsOutItsState: "after later calls",
        HandsOutAConstant: "writing into earlier results",
    },
    "check_actions": {
        ClipsInPlace: "actions before and after",
        TakesAnyNumber: "takes actions with",
        ClipsActions: "takes actions with",
    },
    "check_close": {ClosesOnce: "called again"},
    "check_parity": {OtherDynamics: "SyncVectorEnv", OneInfoMore: "SyncVectorEnv"},
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
