"""Trials of the track: runs of an adapter, or of the policies that set the scales, on a machine."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from agents.evaluation_cache import RUNS, behaviour, sources
from agents.track.adapter_registry import make_adapter
from agents.track.learning_policies import PLANNER
from agents.track.scale_anchors import SCALES, TRAINED, MachineRuns, measured, scales_of, trained_on
from grind_env.plants import Plant
from grind_env.policies.nominal_model import model_of, on
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.track import BASELINE, TASK
from grind_env.training import gru_ppo


@dataclass(frozen=True)
class TrackTrial:
    """Runs of an adapter on a machine."""

    plant: str
    adapter: str  #: name of the adapter, or `SCALES` or `TRAINED`
    seeds: tuple[int, ...]
    training: int = 0  #: seed of a training on the machine
    folder: Path = field(default=RUNS, repr=False, compare=False)  #: folder of the files of trained agents

    def __str__(self) -> str:
        seeds = f"seed {self.seeds[0]}" if len(self.seeds) == 1 else f"{len(self.seeds)} seeds"
        training = f", training {self.training}" if self.adapter == TRAINED else ""
        return f"{self.plant}: {Path(self.adapter).name}, {seeds}{training}"


def run(trial: TrackTrial) -> Mapping[str, MachineRuns]:
    """Return the runs of a trial by their names in the tables."""
    if trial.adapter == SCALES:
        return scales_of(trial.plant, trial.seeds)
    if trial.adapter == TRAINED:
        return {TRAINED: trained_on(trial.plant, trial.seeds, trial.training, trial.folder)}
    policy = make_adapter(trial.adapter, model_of(find_problem(TASK)))
    return {Path(trial.adapter).name: measured(policy, trial.plant, trial.seeds)}


def decides(trial: TrackTrial) -> object:
    """Return the inputs of a trial: its machine, its adapter, and the training code."""
    if trial.adapter == SCALES:
        return _of_machine(trial.plant), None
    known = trial.adapter == TRAINED
    return _of_machine(trial.plant), None if known else _of_adapter(trial.adapter), sources(gru_ppo.__name__)


@cache
def _of_adapter(name: str) -> str:
    """Return the code fingerprints of an adapter and of the policies with which adapters begin."""
    model = model_of(find_problem(TASK))
    policies = [make_adapter(each, model) for each in (name, BASELINE, PLANNER)]
    return f"{[sources(type(each).__module__) for each in policies]} {policies!r}"


@cache
def _of_machine(plant: str) -> str:
    """Return fingerprints of a machine, its model, and the code that carries memory from shift to shift."""
    problem = find_problem(TASK)
    return f"{behaviour(on(problem, plant).simulation())} {behaviour(model_of(problem))} {sources(Plant.__module__)}"
