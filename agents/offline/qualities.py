"""Three qualities of offline data, as random, medium and expert of D4RL, and the hashes by which one knows them again.

`python -m agents.offline.qualities TASK ...` records what is published of these tasks, and writes its hashes anew.
"""

import hashlib
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

from agents.offline.dataset import Steps, recorded
from grind_env.envs.simulation import Simulation
from grind_env.envs.splits import EVERY
from grind_env.errors import GrindError, quoted
from grind_env.policies.evaluation import episode_seeds
from grind_env.policies.policy import Policy
from grind_env.policies.problem import find_problem
from grind_env.policies.registry import make_policy, policy_names
from grind_env.task_version import TASK_VERSION
from grind_env.toml import read_toml, toml_text

QUALITIES: Mapping[str, tuple[str, ...]] = {
    "novice": ("random",),
    "rule": ("adaptive_rule",),
    "planner": ("mpc", "hindsight"),
}
"""The policy of each quality, the first one that an environment has.

Whoever draws E and D; a rule on what a machine measures, tuned for the task; and a planner that knows the true state,
whose E and D stand beside observations from which no one could choose so well.
"""
EPISODES, SEEDS = 200, "training"
"""What is published: so many episodes of the split `all`."""
FILE = Path(__file__).with_name("hashes.toml")
VERSION = "task_version"


def policy_of(quality: str, simulation: Simulation, configs: Path | None = None) -> Policy:
    """The policy of a quality.

    Raises:
        GrindError: there is no such quality, or the environment has no policy of it.
        ConfigError: it is not tuned.
    """
    if quality not in QUALITIES:
        raise GrindError(f"there is no quality {quoted(quality)}: choose from {', '.join(QUALITIES)}")
    known = policy_names(simulation)
    for name in QUALITIES[quality]:
        if name in known:
            return make_policy(name, simulation, configs)
    raise GrindError(f"{simulation.task.name} has no {quality}: no planner can try its blocks before it decides")


def content_hash(episodes: Iterable[Steps]) -> str:
    """SHA-256 of the episodes, one after the other: what they show, choose, earn and spoil."""
    digest = hashlib.sha256()
    for episode in episodes:
        for part in episode:
            digest.update(part.astype(part.dtype.newbyteorder("<")).tobytes())
    return digest.hexdigest()


def published() -> dict[str, dict[str, str]]:
    """Hashes of the published datasets of this task version, by task and quality."""
    document = read_toml(FILE)
    return {task: hashes for task, hashes in document.items() if hashes.pop(VERSION) == TASK_VERSION}


def record(task: str) -> dict[str, str]:
    """The hashes of what is published of a task, from new records."""
    problem = find_problem(task)
    policies = {quality: policy_of(quality, problem.simulation()) for quality in QUALITIES}
    data = {name: recorded(policy, problem, episode_seeds(SEEDS, EPISODES)) for name, policy in policies.items()}
    return {name: content_hash(each) for name, each in data.items()}


def verdict(task: str, policy: Policy, content: str, episodes: int, seeds: str, split: str) -> str:
    """What the hash of a dataset says of it."""
    known = published().get(task, {})
    names = [quality for quality in known if policy.name in QUALITIES[quality]]
    if not names or (episodes, seeds, split) != (EPISODES, SEEDS, EVERY):
        return f"sha256 {content}"
    return f"sha256 {content}, {'as published' if known[names[0]] == content else 'NOT as published'}"


if __name__ == "__main__":
    written = {name: {VERSION: TASK_VERSION, **hashes} for name, hashes in published().items()}
    for name in sys.argv[1:]:
        written[name] = {VERSION: TASK_VERSION, **record(name)}
    FILE.write_text(toml_text(dict(sorted(written.items()))), encoding="utf-8")
