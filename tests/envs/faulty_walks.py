"""Vector environments with one fault each."""

from typing import Any, ClassVar

import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from tests.envs.harness import Array
from tests.envs.walks import Walks


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


class IgnoresMaskWithoutSeed(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return super().reset(seed=seed, options=options if seed is not None else None)


class IgnoresMaskWithAutoreset(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return super().reset(seed=seed, options=options if self.mode is AutoresetMode.DISABLED else None)


class StaysDue(Walks):
    """In NEXT_STEP mode a reset by the caller after an end is followed by another one."""

    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        due = self.over.copy()
        result = super().reset(seed=seed, options=options)
        self.over = due & (self.mode is AutoresetMode.NEXT_STEP)
        return result


class StaysDueIfMasked(StaysDue):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return (super() if options else super(StaysDue, self)).reset(seed=seed, options=options)


class GarbageInFinalInfo(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        if "final_info" in info:
            info["final_info"]["place"] -= 1000.0 * info["_final_info"]
        return *before, info


class FinalInfoOfTheNextEpisode(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        if "final_info" in info:
            info["final_info"] = {"goal": info["goal"].copy(), "_goal": info["_final_info"].copy()}
        return *before, info


class SinglePrecisionAtTimes(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        if "place" in info and (info["place"] > 1.0).any():
            info["place"] = info["place"].astype(np.float32)
        return *before, info


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
