"""Contexts of an episode: factors that a user can fix, and the split of the drawn factors.

`env.reset(options={"context": {"kA": 2.0, "material": "inconel_718"}, "split": "inner"})` fixes the factors named and
draws the rest from the split `inner`. Both hold for later episodes too, until a reset names others; None removes a
context, and the split `all` holds nothing out. `"nominal"` stands for `nominal_context(task)`, which leaves nothing to
chance. For the vector environment either may be a list, one entry for each sub-environment.

`reset` with the option `plant` takes another machine of the same families, if the environment was made with an
out-of-model machine (`plant="meter"`, see `grind_env.plants`). The option holds until the next; None stands for the
machine of the environment. A name without a seed draws a new machine for every episode.

A factor without effect in a task is refused. `grind/Job-v0` takes the factors of lot, wheel, coolant and noise.

A fixed material in a task of one material is not observed, not even in `observation="full"`. Like other factors it
changes the process and not the layout of the observation, so a policy can be tested on another material. Append the
material to the observation if an agent must know it. In a task of several materials the flag of the fixed one is set;
all flags are 0 for a material outside the task.

Splits (`grind_env.envs.distribution_splits`) hold out ranges of the factors. The distribution of every log-normal
factor (lot, wheel, coolant) is cut into ten ranges of equal probability, and a split draws only from its ranges. So
every lot, wheel and coolant of `interpolation` is new to an agent trained on `inner`, and lies between known factors.
`extrapolation` goes beyond: wear and pressure past the range of the task, half as much stock again, three times the
noise, and another material and wheel of the catalogue, which the observation does not show. The material is no harder
on the wheel than the task's hardest one; the wheel has the same abrasive, with other dulling, grade, G-ratio and
roughness. In `grind/Job-v0` the program fixes material, wheel and stocks. The seed does not choose the split: a seed
makes another episode in each split, from the same random numbers.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.distribution_splits import EVERY, RENAMED, SPLITS, Split
from grind_env.envs.plant_options import read_plant_option, seed_beside
from grind_env.envs.tasks import Task, TaskError
from grind_env.errors import GrindError
from grind_env.message_text import quoted

if TYPE_CHECKING:
    from grind_env.plants import Plants


class ContextError(GrindError):
    """A context or a split that the task does not have."""


class Fixed(NamedTuple):
    """Factors that a context fixes, one number each; NaN for a drawn factor.

    `diamond_flat` is mm, `executions_left` a number of dress executions. `stock`, `kA`, `pm`, `wheel_kA`, `ra_scale`,
    `fc`, `Gref`, `hf`, `coolant_ageing`, `slack` and `noise` are factors, as `CONTEXT_FACTORS` says.
    """

    material: float = math.nan  #: index of the material of all kinds among the materials of the task
    stock: float = math.nan
    kA: float = math.nan
    pm: float = math.nan
    wheel_kA: float = math.nan
    ra_scale: float = math.nan
    fc: float = math.nan
    Gref: float = math.nan
    hf: float = math.nan
    coolant_ageing: float = math.nan
    diamond_flat: float = math.nan
    executions_left: float = math.nan
    slack: float = math.nan
    noise: float = math.nan


FREE = Fixed()  #: context that fixes nothing: every factor is drawn


class Factor(NamedTuple):
    """A number that a context can fix.

    `low`, `high` and `nominal` are in the unit that `meaning` ends with; most have no unit.
    """

    low: float
    high: float
    nominal: float
    meaning: str


#: factors that a context can fix; `material` and `sequence` are names. A task refuses factors of `without_effect`
CONTEXT_FACTORS: Mapping[str, Factor] = {
    "stock": Factor(0.3, 3.0, 1.0, "stock of every part over the nominal one"),
    "kA": Factor(0.05, 20.0, 1.0, "dulling rate of every lot"),
    "pm": Factor(0.2, 5.0, 1.0, "factor of every lot on the wear-flat pressure"),
    "wheel_kA": Factor(0.05, 20.0, 1.0, "dulling rate of every wheel"),
    "ra_scale": Factor(0.2, 5.0, 1.0, "factor of every wheel and part on the roughness"),
    "fc": Factor(0.2, 5.0, 1.0, "factor of the wheel lot on the fracture force, its grade"),
    "Gref": Factor(0.2, 5.0, 1.0, "factor of the wheel lot on the G-ratio"),
    "hf": Factor(0.05, 20.0, 1.0, "factor on the convection of the coolant"),
    "coolant_ageing": Factor(0.0, 20.0, 1.0, "factor on the ageing rate of the coolant"),
    "diamond_flat": Factor(0.0, 0.5, 0.0, "wear flat of the diamond at the start, mm"),
    "executions_left": Factor(0.0, 1000.0, math.nan, "dress executions left at the start"),
    "slack": Factor(0.1, 10.0, 1.0, "time to each due date over the nominal time"),
    "noise": Factor(0.0, 10.0, 0.0, "factor on the noise of all readings and of the pre-gauged stock"),
}


@dataclass(frozen=True, slots=True)
class Given:
    """The fixed part of an episode, before the rest is drawn."""

    fixed: Fixed = FREE  #: numbers of the context
    kinds: tuple[int, ...] | None = None  #: index of the kind of every block, shape (blocks,); None if the task decides
    split: Split = SPLITS[EVERY]  #: the split, which changes the distributions of the drawn factors
    plant: "Plants | None" = None  #: the machine, or the machines to draw from; None for the machine of the simulation


def nominal_context(task: Task, unfixable: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Return the context with all factors nominal: the deterministic task; `unfixable` as for `read_options`."""
    left = task.start.executions_left
    nominal: dict[str, Any] = {name: factor.nominal for name, factor in CONTEXT_FACTORS.items()}
    if left is not None:
        nominal["executions_left"] = (left[0] + left[1]) / 2.0
    nominal["sequence"] = task.nominal_sequence
    without = without_effect(task) if unfixable is None else unfixable
    return {name: value for name, value in nominal.items() if name not in without}


def without_effect(task: Task) -> dict[str, str]:
    """Return the factors that would change nothing in a task, each with the reason."""
    reasons = {
        "coolant_ageing": (task.setup.coolant_ageing == 0.0, "has a coolant that does not age"),
        "executions_left": (task.start.executions_left is None, "starts with a new wheel"),
        "slack": (task.due is None, "has no due dates"),
        "noise": (task.spread.measurement == 0.0 and task.spread.gauge == 0.0, "has exact gauges"),
    }
    return {name: f"{task.name} {reason}" for name, (applies, reason) in reasons.items() if applies}


def read_options(
    task: Task,
    options: Mapping[str, Any] | None,
    before: Given,
    unfixable: Mapping[str, str] | None = None,
    made: "Plants | None" = None,
) -> Given:
    """Read the options of a reset.

    Args:
        task: the task.
        options: options of the reset.
        before: earlier options, which hold unless named.
        unfixable: names without effect in a context, each with the reason; by default `without_effect(task)`.
        made: machines with which the environment was made.

    Raises:
        PlantError: there is no such machine.
        OtherMachine: the environment was not made for it.
        ContextError: if an option, a factor, a split or one of their values is not legal.
    """
    given = before
    for name, value in option_items(options):
        if name == "context":
            fixed, kinds = _context(task, value, without_effect(task) if unfixable is None else unfixable)
            given = replace(given, fixed=fixed, kinds=kinds)
        elif name == "split":
            given = replace(given, split=find_split(value))
        elif name == "plant":
            given = replace(given, plant=read_plant_option(value, made))
        else:
            raise ContextError(f"there is no reset option {name!r}; legal are context, split, plant")
    return given


def with_machines(simulation: Any, given: Sequence[Given], rngs: Sequence[np.random.Generator]) -> Sequence[Given]:
    """Return the fixed parts of episodes with the machine of each; the generators do not advance."""
    made: Plants | None = simulation.plants
    if made is None:
        return given
    named = [each.plant or made for each in given]
    machines = [
        plants if plants.one else plants.seeded(seed_beside(rng)) for plants, rng in zip(named, rngs, strict=True)
    ]
    return [replace(each, plant=plants) for each, plants in zip(given, machines, strict=True)]


def read_all_options(
    options: Mapping[str, Any] | None, before: Sequence[Given], read: Callable[[dict[str, Any], Given], Given]
) -> list[Given]:
    """Read the options of a reset for N sub-environments; the value of an option may be a list of N entries.

    Args:
        options: options of the reset.
        before: earlier options of each.
        read: reads the options of one, given its earlier options.

    Raises:
        ContextError: if an option is not legal, or a list has another length.
    """
    given = list(before)
    for name, value in option_items(options):
        if not isinstance(value, list | tuple):
            once: dict[Given, Given] = {}
            for i, each in enumerate(given):
                if each not in once:
                    once[each] = read({name: value}, each)
                given[i] = once[each]
        elif len(value) == len(given):
            given = [read({name: entry}, each) for entry, each in zip(value, given, strict=True)]
        else:
            raise ContextError(f"{name} has {len(value)} entries, but must have {len(given)}: one for each env")
    return given


def option_items(options: Mapping[str, Any] | None) -> list[tuple[str, Any]]:
    """Return the options of a reset, each with its value.

    Raises:
        ContextError: if they are no dict.
    """
    if options is None:
        return []
    if not isinstance(options, Mapping):
        raise ContextError(f"options is {options!r}, but must be a dict of reset options, or None")
    return list(options.items())


def distinct(given: Sequence[Given]) -> tuple[list[Given], NDArray[np.int64]]:
    """Return the distinct objects, and the index of the object of each of M episodes, shape (M,)."""
    once = {id(each): each for each in given}
    numbers = {key: number for number, key in enumerate(once)}
    return [*once.values()], np.array([numbers[id(each)] for each in given])


def find_split(name: Any) -> Split:
    """Return the split of that name.

    Raises:
        ContextError: if there is no such split.
    """
    if isinstance(name, str) and name in SPLITS:
        return SPLITS[name]
    if isinstance(name, str) and name in RENAMED:
        raise ContextError(f"split is {name!r}, which is called {RENAMED[name]!r} now")
    raise ContextError(
        f"split is {quoted(name)}, but must be one of {', '.join(SPLITS)}: it names contexts; training, validation and"
        " evaluation are seeds"
    )


def _context(task: Task, context: Any, unfixable: Mapping[str, str]) -> tuple[Fixed, tuple[int, ...] | None]:
    if context is None:
        return FREE, None
    if isinstance(context, str) and context == "nominal":
        context = nominal_context(task, unfixable)
    if not isinstance(context, Mapping):
        raise ContextError(f"context is {context!r}, but must be a dict of factors, 'nominal' or None")
    fixed, kinds = {}, None
    for name, value in context.items():
        if isinstance(name, str) and name in unfixable:
            raise ContextError(f"{unfixable[name]}: {name} cannot be fixed, leave it out")
        if name == "sequence":
            kinds = _sequence(task, value)
        elif name == "material":
            fixed[name] = _material(task, value)
        else:
            fixed[name] = _number(task, name, value)
    return Fixed(**fixed), kinds


def _sequence(task: Task, names: Any) -> tuple[int, ...]:
    if not isinstance(names, list | tuple) or not names or not all(isinstance(name, str) for name in names):
        raise ContextError(f"sequence is {names!r}, but must be a list of names of block kinds")
    try:
        return task.numbers(tuple(names), "sequence")
    except TaskError as error:
        raise ContextError(str(error)) from None


def _material(task: Task, name: Any) -> float:
    if not isinstance(name, str) or name not in task.materials:
        raise ContextError(f"material is {name!r}, but must be one of {', '.join(task.materials)}")
    return float(task.materials.index(name))


def _number(task: Task, name: Any, value: Any) -> float:
    if name not in CONTEXT_FACTORS:
        raise ContextError(f"there is no factor {name!r}; legal are material, sequence, {', '.join(CONTEXT_FACTORS)}")
    low, high = CONTEXT_FACTORS[name].low, CONTEXT_FACTORS[name].high
    if name == "executions_left":
        high = float(np.floor((task.wheel.diameter - task.wheel.minimum_diameter) / task.execution_depth))
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not (number and low <= value <= high):
        raise ContextError(f"{name} is {value!r}, but must be a number from {low:g} to {high:g}")
    return float(value)
