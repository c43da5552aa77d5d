"""Views for learning: standardised observations, and rewards relative to the best fixed plan."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.envs.actions import ActionCodec
from grind_env.envs.cost import Outcome
from grind_env.envs.simulation import Simulation
from grind_env.envs.space_metadata import MemoryForm, Standard, memories_of, remembered

REWARD = Outcome._fields.index("reward")
#: lowest reward: lower rewards are raised to it, so that one scrapped part does not dominate an update
WORST_REWARD = -10.0

#: number of episodes of random play, and of the cheapest ones whose observations count: readings of spoilt parts are
#: many times as large. The seeds are the first training seeds
EPISODES, USUAL = 256, 32
JITTER = 0.1  #: largest deviation of E from its mean in an episode, as a share of the geometric range of E
LEAST_DEVIATION = 0.01  #: smallest deviation, for entries that hardly ever change, in the unit of the observation
DIGITS = 3  #: decimals of means and deviations: to these decimals they are the same on every computer


def ease_rewards(rewards: NDArray[Any]) -> NDArray[Any]:
    """Return rewards for learning, shape (N,): raised by one, so that the best fixed plan earns about 0, and cut."""
    return np.maximum(rewards + 1.0, WORST_REWARD).astype(rewards.dtype)


def lateness(simulation: Simulation, observations: Array) -> Array:
    """Return the cost so far of lateness at the next due date, over the reference cost, shape (N,); 0 without dates.

    The environment charges lateness with the last block before a date. Learners get the growth of this cost in each
    block instead: the sum is the same (Ng, Harada, Russell, ICML 1999, 278), and each slow block shows.
    """
    due, names = simulation.task.due, [reading.name for reading in simulation.entries]
    if due is None:
        return np.zeros(len(observations), observations.dtype)
    shown, reading = observations[:, names.index("time_to_due")], simulation.entries[names.index("time_to_due")]
    late = np.maximum(-(shown * reading.scale + reading.offset), 0.0)
    return (late * (due.late / 3600.0 / simulation.task.reference_cost)).astype(observations.dtype)


def fit_standard(simulation: Simulation, codec: ActionCodec, forms: Sequence[MemoryForm]) -> Standard:
    """Return mean and standard deviation of every observation entry, in the better part of random play."""
    memories = memories_of(simulation, codec.space, forms)
    rng, n = np.random.default_rng(0), EPISODES
    episodes = simulation.start([np.random.default_rng(seed) for seed in range(n)])
    for memory in memories:
        memory.begin(n)
    # each episode has its own mean E and its own share of dressed blocks
    speed, share = rng.random(n), rng.random(n)
    seen: list[Array] = []
    alive: list[Array] = []
    earned = np.zeros(n)
    actions: Any = None
    while (running := ~simulation.over(episodes)).any():
        seen.append(remembered(memories, simulation.observe(episodes), actions, running))
        alive.append(running)
        actions = _random(codec, rng, speed, share)
        choice = simulation.applied_choice(episodes, codec.decode(actions))
        outcomes, _ = simulation.step(episodes, *choice, active=np.flatnonzero(running))
        earned += outcomes[:, REWARD]
    cheapest = np.argsort(-earned, kind="stable")[:USUAL]
    shown = np.concatenate([each[cheapest][mask[cheapest]] for each, mask in zip(seen, alive, strict=True)])
    exact = shown.astype(np.float64)
    mean, deviation = np.round(exact.mean(axis=0), DIGITS), np.round(exact.std(axis=0), DIGITS)
    return Standard(tuple(mean.tolist()), tuple(np.maximum(deviation, LEAST_DEVIATION).tolist()))


def _random(codec: ActionCodec, rng: np.random.Generator, speed: Array, share: Array) -> Any:
    """Return a random action of each episode.

    Args:
        codec: converter of the actions.
        rng: random generator.
        speed: mean of E in each episode, from 0 to 1 on the geometric range of E, shape (N,).
        share: share of dressed blocks in each episode, from 0 to 1, shape (N,).
    """
    n = len(speed)
    place = np.clip(speed + rng.uniform(-JITTER, JITTER, n), 0.0, 1.0)
    speeds = np.floor(codec.low * (codec.high / codec.low) ** place + 0.5)
    if codec.levels.size > 0:
        speeds = codec.levels[np.abs(np.log(speeds[:, None] / codec.levels)).argmin(axis=1)]
    dressed = rng.random(n) < share
    executions = np.where(dressed, rng.integers(1, max(codec.executions, 1) + 1, n), 0)
    return codec.encode(speeds, np.minimum(executions, codec.executions), dressed & ("predress" in codec.names))
