"""Wheels and materials from outside a task, for the split `extrapolation`."""

from collections.abc import Sequence
from typing import NamedTuple

from grind_env.envs.tasks.definition import Task
from grind_env.process.corrected import exponents_of
from grind_env.process.entries import Wheel
from grind_env.process.parameters import stroke_parameters


class OtherWheel(NamedTuple):
    """Stroke parameters with another wheel over those with the task's own: factors with no unit."""

    kA: float = 1.0
    fc: float = 1.0
    Gref: float = 1.0
    RaRef: float = 1.0


def other_materials(task: Task) -> Sequence[str]:
    """Materials that a task does not have and that are no harder on its wheel than its own hardest one.

    Harder ones leave next to no good part, whatever is done. The wear flats grow no faster, and no harder pressed.
    """
    entries, own = task.catalogue.materials, {kind.material for kind in task.kinds}
    growth = max(entries[name].wear_flat_growth for name in own)
    pressure = max(entries[name].pressure_factor for name in own)
    found = ((name, entries[name]) for name in task.materials if name not in own)
    soft = ((name, it) for name, it in found if it.wear_flat_growth <= growth and it.pressure_factor <= pressure)
    return [name for name, each in soft if not any(exponents_of(each))]


def other_wheels(task: Task) -> Sequence[OtherWheel]:
    """Return the wheels of the same abrasive that may run as fast, by catalogue name.

    Another wheel differs from the task's own in dulling, grain strength, wear and roughness only. Price, body and
    grains are those of the task's wheel.
    """
    wheels, own = task.catalogue.wheels, task.catalogue.wheels[task.setup.wheel]
    usual = _numbers(task, own)
    fit = (each for _, each in sorted(wheels.items()) if each.abrasive == own.abrasive and each != own)
    ratios = (
        OtherWheel(*(a / b for a, b in zip(_numbers(task, each), usual, strict=True)))
        for each in fit
        if each.maximum_speed >= task.setup.wheel_speed
    )
    return [each for each in ratios if each != OtherWheel()]


def _numbers(task: Task, wheel: Wheel) -> tuple[float, ...]:
    kind, speed = task.kinds[0], task.setup.wheel_speed
    setup = task.catalogue.materials[kind.material], wheel, task.dresser, task.fluid, task.machine
    p = stroke_parameters(*setup, wheel_speed=speed, width=kind.width, height=kind.height)
    return tuple(getattr(p, name) for name in OtherWheel._fields)
