"""The model of a policy on an out-of-model machine: planners, beliefs and experts compute with the model."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation, with_start_of
from grind_env.errors import GrindError
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.message_text import quoted
from grind_env.plants import Plant
from grind_env.plants.plant_names import MODEL
from grind_env.policies.policy import Policy
from grind_env.policies.problem_lookup import Problem


def without_plant(problem: Problem) -> Problem:
    """Return the same problem on the model."""
    return replace(problem, arguments=tuple(each for each in problem.arguments if each[0] != "plant"))


def on(problem: Problem, plant: str) -> Problem:
    """Return the problem on the machine of a name; if the name has no seed, each episode draws a machine."""
    others = without_plant(problem)
    return replace(others, arguments=(*others.arguments, ("plant", plant)))


def machines_name(simulation: Simulation) -> str:
    """Return the name of the machines that a simulation was made with."""
    made = simulation.plants
    return MODEL.name if made is None else made.text


def training_machines(problem: Problem, plant: str | None) -> Problem:
    """Return a problem on the machines for training, by default its own; refuse held-out machines by a GrindError."""
    name = machines_name(problem.simulation()) if plant is None else plant
    if name.startswith("held-out"):
        raise GrindError(
            f"--plant is {quoted(name)}, but these machines judge agents: train on training, public, laws or model"
        )
    return problem if plant is None else on(problem, plant)


def model_of(problem: Problem, name: str = MODEL.name) -> Simulation:
    """Return the simulation that policies compute with: the problem on one machine, by default on the model."""
    simulation: Any = on(problem, name).simulation()
    if not simulation.plants.one:
        raise GrindError(f"model is {quoted(name)}, but a policy holds one machine: give a seed, as '{name}:1'")
    model: Simulation = with_start_of(simulation, simulation.plants.first)
    return model


def model_beside(problem: Problem) -> Simulation | None:
    """Return the model that policies on this problem compute with, or None if the problem grinds on the model."""
    return None if problem.simulation().plants is None else model_of(problem)


def parted(
    policy: Policy, machine: Simulation, model: Simulation | None, begun: Episodes
) -> Callable[[Episodes], Episodes]:
    """Return a function from episodes on a machine to episodes as a policy with a model sees them.

    Without a model, episodes stay unchanged. Values in the machine's memory are shown if the model has the same field.
    Numbers that differ from the model at the start of an episode are replaced by the model's.
    """
    if model is None or policy.sees == "measurements":
        return lambda episodes: episodes
    if not machine.compiled:
        raise GrindError(
            f"{policy.name} sees the {policy.sees}, but the control executes {machine.task.name} step by step, on the"
            " machine and not on a model: choose a policy that sees measurements"
        )
    mine, held = _plant(machine), _plant(model)
    fields = mine.remembers._fields
    common = [(k, fields.index(name)) for k, name in enumerate(held.remembers._fields) if name in fields]
    alike = [(OWN_FROM + k, OWN_FROM + j, begun.wheels[:, OWN_FROM + j] == held.own[k]) for k, j in common]

    def shown(episodes: Episodes) -> Episodes:
        wheels = np.empty((len(episodes.block), OWN_FROM + len(held.own)))
        wheels[:, :OWN_FROM], wheels[:, OWN_FROM:] = episodes.wheels[:, :OWN_FROM], held.own
        for to, of, same in alike:
            wheels[same, to] = episodes.wheels[same, of]
        return replace(episodes, wheels=wheels)

    return shown


def _plant(simulation: Simulation) -> Plant:
    made = simulation.plants
    return MODEL if made is None else made.first
