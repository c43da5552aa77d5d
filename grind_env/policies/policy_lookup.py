"""Lookup of policies by their names on the command line."""

import re
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.message_text import quoted, reason
from grind_env.policies.choices import check_speeds
from grind_env.policies.learned.network import LearnedPolicy
from grind_env.policies.learned.saved import SUFFIX, load_policy
from grind_env.policies.mismatch_fallback import Guarded, guarded
from grind_env.policies.policy import Policy
from grind_env.policies.registry import TRAINED, make_policy
from grind_env.policies.scripted.rules import Fixed

#: folder of the bundled agents: a folder for each name in `TRAINED`, with one file per task
SHIPPED = Path(__file__).with_name("shipped")
FALLBACK = "adaptive_rule"  #: default policy for tasks without a bundled agent

CONSTANT = re.compile(r"E(\d{1,9}(?:\.\d{1,9})?)D(\d{1,9})")
OWN = re.compile(r"([A-Za-z_][\w.]*):([A-Za-z_]\w*)")  #: name of a user's policy: module and name


#: function that reads a model of Stable-Baselines3, such as `grind_env.sb3.load_zip`
Unzip = Callable[[Path, Simulation], Policy]


def named_policy(
    text: str,
    simulation: Simulation,
    configs: Path | None = None,
    unzip: Unzip | None = None,
    *,
    modules: bool = False,
    other_part: bool = False,
) -> Policy:
    """Return the policy of a name.

    Args:
        text: a name of the registry, trained or not, the file of a trained agent (.safetensors), a constant such as
            `E12000D0` (mm/min), or `module:name` for your own; with `guarded:` before it, that policy with a guard.
        simulation: simulation to grind.
        configs: folder of the tuned parameters; by default from `tuned_folder`.
        unzip: function that reads a trusted .zip of Stable-Baselines3; such a file can run code of its author.
        other_part: whether to accept an agent that was trained for another part, as for `load_policy`.
        modules: whether the name may refer to a module, whose code is then run; False for names from untrusted files.

    Raises:
        GrindError: no policy has this name, it has no parameters for the task, or the task does not allow its E or D.
    """
    if text.startswith(Guarded.PREFIX):
        name = text.removeprefix(Guarded.PREFIX)
        return guarded(named_policy(name, simulation, configs, unzip, modules=modules, other_part=other_part))
    if text in TRAINED:
        return load_policy(trained_file(text, simulation.task.name), simulation=simulation, name=text)
    if text.endswith(".zip") and unzip is not None:
        return unzip(Path(text), simulation)
    if text.endswith((SUFFIX, ".zip")):
        return load_policy(Path(text), simulation=simulation, other_part=other_part)
    if constant := CONSTANT.fullmatch(text):
        speed, dresses = float(constant[1]), int(constant[2])
        check_speeds(text, speed, simulation.task, within=True)
        if dresses > (most := simulation.task.action.executions):
            raise GrindError(f"{text}: D is {dresses}, but {simulation.task.name} has 0 to {most}")
        return Fixed(E=speed, D=dresses, name=text)
    if modules and (own := OWN.fullmatch(text)):
        return own_policy(own[1], own[2])
    return make_policy(text, simulation, configs)


def trained_file(name: str, task: str) -> Path:
    """Return the file of a bundled agent, a name in `TRAINED`, for a task.

    Raises:
        GrindError: the package has no such file.
    """
    path = SHIPPED / name / f"{task}{SUFFIX}"
    if not path.is_file():
        raise GrindError(
            f"no policy {name!r} comes with the package for {task}: name a rule, or the file of an agent, which "
            "`grind train` makes"
        )
    return path


def own_policy(module: str, name: str) -> Policy:
    """Return the policy of a name in a module: the object itself, or the result of a class or function.

    Raises:
        GrindError: the module has no such name, or its code fails.
    """
    if (folder := str(Path.cwd())) not in sys.path:  # an installed command does not search the current folder
        sys.path.append(folder)
    try:
        found = getattr(import_module(module), name)
        made: Policy = found() if isinstance(found, type) or not hasattr(found, "act") else found
    except (Exception, SystemExit) as error:  # the user's code may raise anything
        said = f"{quoted(f'{module}:{name}')} names no policy ({reason(error)})"
        raise GrindError(f"{said}: name one of a module that can be imported") from None
    return made


def agent_of(policy: Policy) -> LearnedPolicy | None:
    """Return the trained agent in a policy, with or without a guard; None for other policies."""
    inner = policy.policy if isinstance(policy, Guarded) else policy
    return inner if isinstance(inner, LearnedPolicy) else None


def chosen_policy(
    text: str | None,
    simulation: Simulation,
    configs: Path | None = None,
    unzip: Unzip | None = None,
    *,
    other_part: bool = False,
) -> Policy:
    """Return the policy of a name; without a name the bundled agent of the task.

    Without a bundled agent `FALLBACK` acts, and a sentence in the terminal says so.
    """
    name = text or usual_name(simulation)
    policy = named_policy(name, simulation, configs, unzip, modules=True, other_part=other_part)
    if text is None and usual_name(simulation) == FALLBACK:
        print(
            f"no trained policy is shipped for {simulation.task.name}: {FALLBACK} plays in its place", file=sys.stderr
        )
    return policy


def usual_name(simulation: Simulation) -> str:
    """Return the name of the default policy: the bundled agent of the task, or `FALLBACK`."""
    agent = TRAINED[0]
    return agent if (SHIPPED / agent / f"{simulation.task.name}{SUFFIX}").is_file() else FALLBACK
