"""The safe track over tasks: who decides in them, and how long that takes."""

from dataclasses import fields

from agents.safety.judging import LAGRANGIAN, RULES, UNCONSTRAINED, SafetyRow, SafetyTrial, decides, judge
from agents.safety.page import page
from agents.study import Study, StudyOptions

STEP, EPISODE = 8e-5, 0.1
"""CPU-seconds, by measurement: of a step of a training, and of an episode of a rule, which looks ahead."""


def study(asked: StudyOptions) -> Study:
    """Return the study."""
    trials = [
        SafetyTrial(problem, who, seed, asked.steps, asked.episodes)
        for problem in asked.problems
        for who in (UNCONSTRAINED, LAGRANGIAN, *RULES)
        for seed in range(1 if who in RULES else asked.seeds)
    ]
    return Study(
        name="safety",
        title="The safe track",
        trials=trials,
        run=judge,
        decides=decides,
        columns=[each.name for each in fields(SafetyRow)],
        rows=lambda found: [tuple(each.values()) for each in found.values()],
        page=lambda found: page([SafetyRow(**each) for each in found.values()]),
        episodes=asked.episodes,
        seconds=lambda trial: EPISODE * trial.episodes if trial.who in RULES else STEP * trial.steps,
    )
