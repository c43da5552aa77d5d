"""The example of a page, whose outputs are taken from what the page says and checked by doctest."""

import math
from typing import Any

from grind_env.envs.cost import COST_TERMS, reward_terms
from grind_env.pages.sheet import TaskSheet

COUNT = 4
"""Environments of the vector environment."""


def example(about: TaskSheet) -> str:
    """A session that makes the environment, takes one step, and makes the vector environment."""
    env: Any = about.env
    size, width = len(about.readings), env.action_space.shape[0]
    lines = [">>> import gymnasium as gym", ">>> import grind_env"]
    program = ""
    if about.note.program:
        lines.append(f'>>> program = grind_env.examples.path("{about.note.program}")')
        program = ", program=str(program)"
    lines += [
        f'>>> env = gym.make("{about.id}"{program})',
        ">>> env.action_space",
        repr(env.action_space),
        ">>> observation, info = env.reset(seed=1)",
        ">>> observation.shape",
        f"({size},)",
        ">>> env.unwrapped.observation_info()[0].name",
        repr(about.readings[0].name),
        ">>> observation, reward, terminated, truncated, info = env.step(env.action_space.low)",
        ">>> terminated, truncated",
        f"({about.steps == 1}, False)",
    ]
    least = f"{about.reward.least:g} <= " if math.isfinite(about.reward.least) else ""
    lines += [f">>> {least}reward <= {about.reward.most:g}", "True"]
    terms = COST_TERMS if about.task is None else reward_terms(about.task)
    names = [f"reward_{name}" for name in terms]
    lines += ['>>> [name for name in info if name.startswith("reward_")]', repr(names)]
    lines += [
        '>>> info["E"], info["D"]',
        f"({about.codec.low}, 0.0)",
        f'>>> vector = gym.make_vec("{about.id}", num_envs={COUNT}{program})',
        ">>> observations, infos = vector.reset(seed=1)",
        ">>> observations.shape, vector.action_space.shape",
        f"(({COUNT}, {size}), ({COUNT}, {width}))",
    ]
    return "\n".join(lines)
