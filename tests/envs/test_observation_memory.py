"""The stack of past observations against lists kept by hand."""

from typing import Any

import numpy as np
import pytest
from gymnasium import spaces
from hypothesis import given
from hypothesis import strategies as st

from grind_env.belief.wheel_belief import WheelBelief
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.filter_members import MemberModel
from grind_env.envs.observation_memory import BeliefMemory, StackMemory, WrapperError, action_numbers, belief_entries
from grind_env.envs.observations import bounds
from grind_env.envs.tasks import load_task
from tests.envs.harness import Array, refusal, start

SEEN = spaces.Box(np.array([-1.0, 2.0], np.float32), np.array([1.0, 3.0], np.float32))
ACTION = spaces.Box(-1.0, 1.0, (3,), np.float32)


def shown_by_hand(seen: list[Array], acted: list[Array | None], n: int) -> list[float]:
    """Return the last n pairs of one episode, oldest first, after zeros."""
    pairs = [[*o, *(np.zeros(3) if a is None else a)] for o, a in zip(seen, acted, strict=True)]
    padding = [[0.0] * 5] * max(n - len(pairs), 0)
    return [float(np.float32(x)) for pair in (padding + pairs)[-n:] for x in pair]


@given(st.integers(0, 10**6), st.integers(1, 5))
def test_the_stack_holds_the_last_pairs_of_the_current_episode(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    memory = StackMemory(SEEN, ACTION, n)
    memory.begin(3)
    seen: list[list[Array]] = [[], [], []]
    acted: list[list[Array | None]] = [[], [], []]
    for _ in range(12):
        mask, restarted = rng.random(3) < 0.8, rng.random(3) < 0.2
        observations = np.array([SEEN.low + rng.random(2) for _ in range(3)], np.float32).clip(SEEN.low, SEEN.high)
        actions = None if rng.random() < 0.2 else rng.uniform(-1.0, 1.0, (3, 3)).astype(np.float32)
        memory.restart(restarted)
        shown = memory.take(observations, actions, mask)
        for i in range(3):
            if restarted[i]:
                seen[i], acted[i] = [], []
            if mask[i]:
                seen[i].append(observations[i])
                acted[i].append(None if actions is None else actions[i])
            assert shown[i].tolist() == shown_by_hand(seen[i], acted[i], n)
            assert shown[i] in memory.space


def test_the_space_of_a_stack_repeats_n_times_and_contains_zeros() -> None:
    memory = StackMemory(SEEN, ACTION, 2)
    assert memory.space.low.tolist() == [-1.0, 0.0, -1.0, -1.0, -1.0] * 2
    assert memory.space.high.tolist() == [1.0, 3.0, 1.0, 1.0, 1.0] * 2


CHOICES: list[tuple[spaces.Space[Any], Any, list[list[float]]]] = [
    (spaces.Discrete(5), [0, 4, 1], [[0.0], [1.0], [0.25]]),
    (spaces.Discrete(3, start=-1), [-1, 1, 0], [[0.0], [1.0], [0.5]]),
    (spaces.Discrete(1), [0, 0], [[0.0], [0.0]]),
    (spaces.MultiDiscrete([11, 3]), [[10, 0], [5, 1]], [[1.0, 0.0], [0.5, 0.5]]),
    (ACTION, [[0.5, -1.0, 1.0]], [[0.5, -1.0, 1.0]]),
]


@pytest.mark.parametrize(("space", "actions", "expected"), CHOICES)
def test_choices_become_numbers_from_0_to_1(space: Any, actions: Any, expected: Any) -> None:
    numbers = action_numbers(space, np.array(actions))
    assert numbers.tolist() == expected
    memory = StackMemory(SEEN, space, 1)
    memory.begin(len(actions))
    shown = memory.take(np.tile(SEEN.low, (len(actions), 1)), np.array(actions), np.ones(len(actions), bool))
    assert shown[:, 2:].tolist() == expected
    assert all(row in memory.space for row in shown)


@pytest.mark.parametrize(
    ("observation", "action", "n", "part"),
    [
        (SEEN, ACTION, 0, "n is 0"),
        (spaces.Discrete(3), ACTION, 2, "Discrete"),
        (spaces.Box(0.0, 1.0, (2, 2)), ACTION, 2, "Box with one axis"),
        (SEEN, spaces.Dict({"E": ACTION}), 2, "Dict"),
        (SEEN, spaces.Box(0.0, 1.0, (2, 2)), 2, "one axis"),
        (SEEN, spaces.MultiDiscrete([[2, 2]]), 2, "one axis"),
    ],
)
def test_spaces_that_cannot_be_stacked_are_refused(observation: Any, action: Any, n: int, part: str) -> None:
    assert part in refusal(WrapperError, StackMemory, observation, action, n)


def test_the_scaled_belief_is_appended_to_the_observation() -> None:
    simulation, entries = BlockSimulation(load_task("power_limited")), belief_entries()
    memory, belief = BeliefMemory(simulation, 8), WheelBelief(MemberModel(simulation), 8)
    memory.begin(4)
    belief.begin(4)
    episodes, everyone = start(simulation, 4), np.ones(4, bool)
    for _ in range(10):
        observations = simulation.observe(episodes)
        shown = memory.take(observations, None, everyone)
        expected = np.stack(belief.update(observations), axis=1) / [entry.scale for entry in entries]
        assert (shown[:, : observations.shape[1]] == observations).all()
        np.testing.assert_allclose(shown[:, observations.shape[1] :], expected, rtol=1e-6)
        assert all(row in memory.space for row in shown)
        simulation.step(episodes, np.full(4, 9000.0), np.zeros(4))
    assert memory.space.shape == (len(bounds(simulation.entries)[0]) + len(entries),)
