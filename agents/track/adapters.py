"""The adapters of the track by name."""

from collections.abc import Callable
from functools import partial

from agents.track.learning import Adviser, Calibrated, Rl2
from grind_env.envs.simulation import Simulation
from grind_env.policies.naming import named_policy, own_policy
from grind_env.policies.policy import Policy

RETRAINING = "agents.track.retraining"
"""It imports PyTorch, which takes seconds."""
ADAPTERS: dict[str, Callable[[], Policy]] = {
    Calibrated.name: Calibrated,
    Adviser.name: Adviser,
    Rl2.name: Rl2,
    "fine_tuned": partial(own_policy, RETRAINING, "FineTuned"),
    "robust_calibrated": partial(own_policy, RETRAINING, "RobustCalibrated"),
}
"""Policies that learn on a machine, each made anew for every run."""


def make_adapter(name: str, model: Simulation) -> Policy:
    """Return a new policy: one of `ADAPTERS`, or what `named_policy` finds (a name, a file, `module:Class`)."""
    return ADAPTERS[name]() if name in ADAPTERS else named_policy(name, model, modules=True)
