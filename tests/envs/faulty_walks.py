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


class OtherSpace(Walks):
    def __init__(self, mode: AutoresetMode) -> None:
        super().__init__(mode)
        self.single_action_space = spaces.Box(-2.0, 2.0, (1,), np.float32)
        self.action_space = batch_space(self.single_action_space, 3)


class SharedMetadata(Walks):
    SHARED: ClassVar[dict[str, Any]] = {}

    def __init__(self, mode: AutoresetMode) -> None:
        super().__init__(mode)
        self.SHARED["autoreset_mode"] = mode
        self.metadata = self.SHARED


class SeedTimesTwo(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return super().reset(seed=[seed + 2 * i for i in range(3)] if isinstance(seed, int) else seed, options=options)


class SharedSeeds(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        seeds = [each + sum(seed) - 3 * seed[0] - 3 for each in seed] if isinstance(seed, list) else seed
        return super().reset(seed=seeds, options=options)


class BeyondBounds(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        observations, info = super().reset(seed=seed, options=options)
        return observations + np.float32(30.0), info


class ColumnOfRewards(Walks):
    def step(self, actions: Array) -> Any:
        observations, rewards, *rest = super().step(actions)
        return observations, rewards[:, None], *rest


class FlagsAsNumbers(Walks):
    def step(self, actions: Array) -> Any:
        *before, truncations, info = super().step(actions)
        return *before, truncations.astype(float), info


class NoMask(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        info.pop("_place", None)
        return *before, info


class LeakyMask(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        if "name" in info:
            info["name"][:] = "step"
        return *before, info


class NoisyActions(Walks):
    def step(self, actions: Array) -> Any:
        return super().step(actions * np.random.default_rng().uniform(0.9, 1.0, actions.shape).astype(np.float32))


class StepsOnReset(Walks):
    """In NEXT_STEP mode the first action of an episode is taken with the reset."""

    def step(self, actions: Array) -> Any:
        over = self.over.copy()
        _, *rest = super().step(actions)
        for i in np.flatnonzero(over & (self.mode is AutoresetMode.NEXT_STEP)):
            self.observations[i] = self.walks[i].step(actions[i])[0]
        return self.observations.copy(), *rest


class NoFinalObs(Walks):
    def step(self, actions: Array) -> Any:
        *before, info = super().step(actions)
        info.pop("final_obs", None)
        info.pop("_final_obs", None)
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


class MaskWithoutSeed(Walks):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return super().reset(seed=None if options else seed, options=options)


class HandsOutItsState(Walks):
    def step(self, actions: Array) -> Any:
        return self.observations, *super().step(actions)[1:]


class ClipsInPlace(Walks):
    def step(self, actions: Array) -> Any:
        result = super().step(actions)
        actions *= 0.5
        return result


class ClipsActions(Walks):
    def step(self, actions: Array) -> Any:
        return super().step(np.nan_to_num(actions, nan=0.0).clip(-1.0, 1.0))


class ClosesOnce(Walks):
    def close(self, **kwargs: Any) -> None:
        del self.walks


class OtherDynamics(Walks):
    def step(self, actions: Array) -> Any:
        return super().step(0.999 * actions)
