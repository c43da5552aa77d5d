"""Policies as one names them on the command line."""

import re
import sys
from collections.abc import Callable
from pathlib import Path

from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.policies.choices import speed_bounds
from grind_env.policies.guard import Guarded, guarded
from grind_env.policies.learned.saved import SUFFIX, load_policy
from grind_env.policies.policy import Policy
from grind_env.policies.registry import make_policy
from grind_env.policies.scripted.rules import Fixed

SHIPPED = Path(__file__).with_name("shipped")
"""Folder of the trained policies that come with the package, one a task."""
FALLBACK = "adaptive_rule"
"""Stands in where none comes with it."""

CONSTANT = re.compile(r"E(\d{1,9}(?:\.\d{1,9})?)D(\d{1,9})")


Unzip = Callable[[Path, Simulation], Policy]
"""Reads a model of Stable-Baselines3: `grind_env.sb3.load_zip`."""


def named_policy(text: str, simulation: Simulation, configs: Path | None = None, unzip: Unzip | None = None) -> Policy:
    """The policy that a text names.

    Args:
        text: one of the registry, the file of a trained agent (.safetensors), or a constant such as `E12D0`; with
            `guarded:` before it, that policy with a guard.
        simulation: what it is to grind.
        configs: folder of the tuned parameters; by default that of `tuned_folder`.
        unzip: reads a .zip of Stable-Baselines3 that its user trusts; such a file can run code of its author.

    Raises:
        GrindError: if there is none, it has no parameters for the task, or the task does not have such an E or D.
    """
    if text.startswith(Guarded.PREFIX):
        return guarded(named_policy(text.removeprefix(Guarded.PREFIX), simulation, configs, unzip))
    if text.endswith(".zip") and unzip is not None:
        return unzip(Path(text), simulation)
    if text.endswith((SUFFIX, ".zip")):
        return load_policy(Path(text), simulation=simulation)
    if constant := CONSTANT.fullmatch(text):
        speed, dresses = float(constant[1]), int(constant[2])
        low, high = (0.001 * bound for bound in speed_bounds(simulation.task))
        if not low <= speed <= high:
            raise GrindError(f"{text}: E is {speed:g} m/min, but {simulation.task.name} has {low:g} to {high:g}")
        if dresses > (most := simulation.task.action.executions):
            raise GrindError(f"{text}: D is {dresses}, but {simulation.task.name} has 0 to {most}")
        return Fixed(E=speed, D=dresses, name=f"constant E {speed:g} m/min, D {dresses}")
    return make_policy(text, simulation, configs)


def chosen_policy(
    text: str | None, simulation: Simulation, configs: Path | None = None, unzip: Unzip | None = None
) -> Policy:
    """As `named_policy`; without a text the trained policy that comes with the package for the task.

    Where there is none, `FALLBACK` stands in, as a sentence in the terminal says.
    """
    if text is None:
        path = SHIPPED / f"{simulation.task.name}{SUFFIX}"
        if path.is_file():
            return load_policy(path, simulation=simulation)
        policy = named_policy(FALLBACK, simulation, configs)
        print(
            f"no trained policy is shipped for {simulation.task.name}: {FALLBACK} plays in its place", file=sys.stderr
        )
        return policy
    return named_policy(text, simulation, configs, unzip)
