"""The adapters of the track by name."""

from collections.abc import Callable
from copy import deepcopy

from agents.track.learning import CalibratedPlanner
from grind_env.envs.simulation import Simulation
from grind_env.policies.naming import named_policy
from grind_env.policies.policy import Policy

ADAPTERS: dict[str, Callable[[], Policy]] = {CalibratedPlanner.name: CalibratedPlanner}
"""Policies that learn on a machine. Every run makes a new one."""


def make_adapter(name: str, model: Simulation) -> Policy:
    """Return a new policy: one of `ADAPTERS`, or what `named_policy` finds (a name, a file, `module:Class`)."""
    # a copy: a module may have one object, which must not take what it learns to the next machine
    return ADAPTERS[name]() if name in ADAPTERS else deepcopy(named_policy(name, model, modules=True))
