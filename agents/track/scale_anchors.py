"""Scales of the track: a plan, a planner and an agent that were tuned or trained on the machine itself."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from agents.benchmark.agent_files import from_file
from agents.benchmark.agent_training import plain_agent, training_of
from agents.tuning.rule_tuning import Tuner, tune_policy
from grind_env.policies.nominal_model import model_of, on
from grind_env.policies.planners.known_state import ModelPredictive
from grind_env.policies.policy import Policy
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import FIXED_PLANS, TUNED, policy_names
from grind_env.policies.track import TASK, TrackRuns, run_shifts
from grind_env.policies.tuned_parameters import arguments
from grind_env.training.gru_ppo import Settings

PLAN, PLANNER, TRAINED = "plan", "planner", "trained_on_machine"
SCALES = "scales"  #: name, in place of an adapter, for plan and planner
EVALUATIONS, STARTS, EPISODES = 300, 2, 48  #: numbers of evaluations, CMA-ES runs and episodes for tuning on a machine
TRAININGS, STEPS = 3, 1_000_000
#: first horizon of the planner, blocks, and gain of a doubled horizon, points of the track score, below which the
#: search stops
HORIZON, ENOUGH = 10, 0.5


class MachineRuns(NamedTuple):
    """Runs on a machine, description of the policy, and CPU time of a run, s."""

    runs: TrackRuns
    said: str
    cpu_seconds: float

    @staticmethod
    def read(row: Sequence[Any]) -> "MachineRuns":
        """Return the runs in a row of JSON."""
        return MachineRuns(TrackRuns(*map(np.array, row[0])), *row[1:])


def measured(policy: Policy, plant: str, seeds: Sequence[int], said: str = "", *, knows: bool = False) -> MachineRuns:
    """Return runs of a policy with their CPU time; arguments as for `run_shifts`."""
    begin = time.process_time()
    runs = run_shifts(policy, plant, seeds, knows=knows)
    return MachineRuns(runs, said, (time.process_time() - begin) / len(seeds))


def scales_of(plant: str, seeds: Sequence[int]) -> dict[str, MachineRuns]:
    """Return runs of the best fixed plan of a machine, and of the planner that knows the machine and its state.

    Both are tuned on tuning seeds of this machine. The horizon of the planner is doubled until the gain is small.
    """
    tuner = Tuner(on(find_problem(TASK), plant).simulation(), None, EPISODES)

    def tuned(names: list[str]) -> Any:
        found = {name: tune_policy(name, tuner, EVALUATIONS, STARTS) for name in names}
        best = min(names, key=lambda name: found[name].validation_cost)
        return TUNED[best](**arguments(found[best].parameters))

    fixed = tuned([name for name in FIXED_PLANS if name in policy_names(tuner.simulation)])
    plan = measured(fixed, plant, seeds, f"E{fixed.E:.0f}D{fixed.D}, dresses every {fixed.every}", knows=True)
    rule, horizon = tuned(["full_state_rule"]), HORIZON
    best = measured(ModelPredictive(rule, horizon), plant, seeds, f"{horizon} blocks ahead", knows=True)
    while horizon < tuner.task.blocks:
        horizon *= 2
        longer = measured(ModelPredictive(rule, horizon), plant, seeds, f"{horizon} blocks ahead", knows=True)
        gain = best.runs.cost.mean() - longer.runs.cost.mean()
        best = longer if gain > 0.0 else best
        if gain < ENOUGH / 100.0 * (plan.runs.cost.mean() - longer.runs.cost.mean()):
            break
    return {PLAN: plan, PLANNER: best}


def trained_on(plant: str, seeds: Sequence[int], training: int, folder: Path) -> MachineRuns:
    """Return runs of an agent that was trained on the machine alone, from measurements; its file is in `folder`."""
    problem = find_problem(TASK)
    path = plain_agent(on(problem, plant), TRAINED, Settings(steps=STEPS), training, folder)
    found = measured(from_file(path, model_of(problem), TRAINED), plant, seeds)
    return found._replace(cpu_seconds=found.cpu_seconds + training_of(path).cpu_seconds)
