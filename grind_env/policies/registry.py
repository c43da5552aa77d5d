"""Registry of the policies by name."""

import math
from collections.abc import Callable, Sequence
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any, get_origin

from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.message_text import did_you_mean, quoted
from grind_env.policies.planners.belief_planner import BeliefPlanner
from grind_env.policies.planners.hindsight import Hindsight
from grind_env.policies.planners.known_state import FullStateRule, ModelPredictive
from grind_env.policies.policy import Policy
from grind_env.policies.scripted import rules
from grind_env.policies.scripted.belief_rule import BeliefRule
from grind_env.policies.scripted.empirical_rule import EmpiricalRule
from grind_env.policies.scripted.handbook import Handbook
from grind_env.policies.scripted.look_ahead import LookAhead
from grind_env.policies.tuned_parameters import ConfigError, tuned_arguments, tuned_folder

UNIFORM_PLANS = ("constant", "interval")
#: plans that a shop can write into a program without sensors; the best plan scores 0. The last plan is for tasks with
#: several kinds of block
FIXED_PLANS = (*UNIFORM_PLANS, "constant_per_kind")
REFERENCE = "hindsight"  #: policy that scores 100

UNTUNED: dict[str, Callable[[], Policy]] = {
    "random": rules.Random,
    "handbook": Handbook,
    "empirical_rule": EmpiricalRule,
    "belief_planner": BeliefPlanner,
    REFERENCE: Hindsight,
}

#: policies with tuned parameters. All lists of policies begin with the policy that knows least
TUNED: dict[str, Callable[..., Policy]] = {
    "constant": partial(rules.Fixed, name="constant"),
    "interval": partial(rules.Fixed, name="interval"),
    "constant_per_kind": rules.ConstantPerKind,
    "power_threshold": rules.PowerThreshold,
    "adaptive_speed": rules.AdaptiveSpeed,
    "adaptive_dress": rules.AdaptiveDress,
    "adaptive_rule": rules.AdaptiveRule,
    "belief_rule": BeliefRule,
    "look_ahead": LookAhead,
    "dullness_rule": partial(FullStateRule, gK=0.0, gR=0.0, wK=0.0, name="dullness_rule"),
    "growth_rule": partial(FullStateRule, gR=0.0, name="growth_rule"),
    "roughness_rule": partial(FullStateRule, gK=0.0, wK=0.0, name="roughness_rule"),
    "full_state_rule": FullStateRule,
}

#: adaptive rule without one of its decisions, and full-state rule with part of its knowledge: only the dullness of the
#: wheel, or also the dulling rate of the lot, or also the Ra of wheel and part. They show the value of each decision
#: and each piece of knowledge. `make_policy` takes their names, but no list of policies has them
ABLATIONS = ("adaptive_speed", "adaptive_dress", "dullness_rule", "growth_rule", "roughness_rule")
#: policies without reference scores, in no list: the fallback on out-of-model machines, and the planner on the belief
UNSCORED = ("empirical_rule", "belief_planner")
#: bundled agents, each with a folder: the first is trained on the model, the second on a public machine per episode
TRAINED = ("plain_gru", "robust")
RENAMED = {"bc": "plain_gru", "shipped": "plain_gru"}  #: new name of each renamed policy
#: policies that simulate a block many times before they decide
BRANCHING = ("belief_rule", "look_ahead", "belief_planner", "mpc", REFERENCE)


def policy_names(simulation: Simulation) -> list[str]:
    """Return the names of the policies of an environment, from the one that knows least to the one that knows most."""
    names = ["random", "handbook", *TUNED, "mpc", REFERENCE]
    return [name for name in fitting(names, simulation) if name not in ABLATIONS]


def fitting(names: Sequence[str], simulation: Simulation) -> list[str]:
    """Return the given policies that can decide in an environment."""
    unfit = {
        *(["constant_per_kind"] if len(simulation.task.kinds) == 1 else []),
        *(BRANCHING if not simulation.compiled else ()),
    }
    return [name for name in names if name not in unfit]


def check_names(simulation: Simulation, names: Sequence[str] | None) -> Sequence[str]:
    """Return the checked names; for None return the list of policies of the environment.

    Raises:
        ConfigError: a name is no policy of the environment.
    """
    listed = policy_names(simulation)
    known = [*listed, *ABLATIONS, *fitting(UNSCORED, simulation)]
    if unknown := set(names or ()) - set(known):
        name = min(unknown)
        if name in RENAMED:
            raise ConfigError(f"{name} was renamed to {RENAMED[name]}")
        if name in TRAINED:
            raise ConfigError(
                f"{quoted(name)} is a trained agent and is read from a file: name it to grind_env.evaluate, or make it"
                " by grind_env.policies.policy_lookup.named_policy"
            )
        raise ConfigError(
            f"there is no policy {quoted(name)}{did_you_mean(name, [*known, *TRAINED])} for {simulation.task.name}: "
            f"choose from {', '.join(known)}"
        )
    return listed if names is None else names


def make_policy(name: str, simulation: Simulation, folder: Path | None = None) -> Policy:
    """Return the policy of a name, with the parameters tuned for the environment; see `tuned_folder`.

    Raises:
        ConfigError: the policy does not exist, it has not been tuned for the environment yet, or the file does not have
            the parameters that it takes.
    """
    check_names(simulation, [name])
    if name in UNTUNED:
        return UNTUNED[name]()
    if name == "mpc":
        return ModelPredictive(_tuned_policy("full_state_rule", simulation.task, folder))
    policy: Policy = _tuned_policy(name, simulation.task, folder)
    return policy


def _tuned_policy(name: str, task: Task, folder: Path | None) -> Any:
    """Return the policy with the parameters in its file."""
    place = f"{tuned_folder(task, folder) / task.name}.toml: [{name}.parameters]"
    try:
        policy: Any = TUNED[name](**tuned_arguments(name, task, folder))
    except (TypeError, AttributeError) as error:
        raise ConfigError(f"{place} does not fit ({error}): tune again with --fresh") from None
    # a user may have edited the file, and a wrong form would fail only in the middle of an episode
    for each in fields(policy):
        if each.init and get_origin(each.type) is tuple:
            _check(
                place, each.name, getattr(policy, each.name), f"a list of {len(task.kinds)} numbers", len(task.kinds)
            )
        elif each.init and each.type in (float, int):
            _check(place, each.name, (getattr(policy, each.name),), "a number", 1)
    if isinstance(policy, rules.Fixed | rules.AdaptiveSpeed) and not (
        isinstance(policy.every, int) and policy.every >= 1
    ):
        raise ConfigError(f"{place} has no every that fits: give a whole number of blocks, or tune again with --fresh")
    return policy


def _check(place: str, name: str, values: Any, wanted: str, count: int) -> None:
    """Raise a ConfigError unless a parameter has `count` finite numbers."""
    numbers = isinstance(values, tuple) and all(isinstance(x, float | int) and math.isfinite(x) for x in values)
    if not numbers or len(values) != count:
        raise ConfigError(f"{place} has no {name} that fits: give {wanted}, or tune again with --fresh")
