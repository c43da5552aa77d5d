"""What every study is asked: the same options, which its command and its trials share."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from agents.study import Options
from grind_env.policies.problem import Problem


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a study is asked for.

    Attributes:
        problems: what is ground.
        episodes: evaluation episodes.
        seeds: trainings of each kind, or runs on each machine.
        steps: environment steps of a training.
        configs: folder of the tuned parameters; by default that of `tuned_folder`.
        results: folder of the tables.
        options: how the trials are run.
    """

    problems: Sequence[Problem]
    episodes: int
    seeds: int
    steps: int
    configs: Path | None
    results: Path
    options: Options
