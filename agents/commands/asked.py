"""Options that the command of a study hands to the study."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from agents.study import Options
from grind_env.policies.problem import Problem


@dataclass(frozen=True, kw_only=True)
class StudyOptions:
    """Options of a study.

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
