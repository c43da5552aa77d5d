"""Policies of the track that learn on a machine, by name."""

from copy import deepcopy

from grind_env.envs.simulation import Simulation
from grind_env.policies.policy import Policy
from grind_env.policies.policy_lookup import named_policy

#: class of each adapter, by its name
ADAPTERS = {
    "calibrated": "agents.track.learning_policies:CalibratedPlanner",
    "empirical_rule_learns": "agents.track.learning_policies:LearningRule",
    "rl2": "agents.track.learning_policies:Rl2",
    "rl2_forgets": "agents.track.learning_policies:ForgetfulRl2",
    "fine_tuned": "agents.track.retraining:FineTuned",
    "robust_calibrated": "agents.track.retraining:RobustCalibrated",
}


def make_adapter(name: str, model: Simulation) -> Policy:
    """Return a new policy: one of `ADAPTERS`, or a policy for `named_policy` (a name, a file, `module:Class`)."""
    # a copy, because an object of a module must not carry what it learns to the next machine
    return deepcopy(named_policy(ADAPTERS.get(name, name), model, modules=True))
