"""Wheels and materials from outside a task, for the split `extrapolation`."""

from collections.abc import Sequence
from typing import NamedTuple

from grind_env.envs.tasks.definition import Task
from grind_env.process.catalogue_parameters import stroke_parameters
from grind_env.process.entries import Wheel
from grind_env.process.force_correction import exponents_of


class OtherWheel(NamedTuple):
    """Ratios of stroke parameters with another wheel to those with the wheel of the task: factors with no unit."""

    kA: float = 1.0
    fc: float = 1.0
    Gref: float = 1.0
    RaRef: float = 1.0


def other_materials(task: Task) -> Sequence[str]:
    """Return the materials outside a task that are no harder on its wheel than the task's hardest material.

    With harder materials, almost no part is good under any policy. With the returned materials, wear flats grow no
    faster, and the pressure on them is no higher.
    """
    entries, own = task.catalogue.materials, {kind.material for kind in task.kinds}
    growth = max(entries[name].wear_flat_growth for name in own)
    pressure = max(entries[name].pressure_factor for name in own)
    found = ((name, entries[name]) for name in task.materials if name not in own)
    soft = ((name, it) for name, it in found if it.wear_flat_growth <= growth and it.pressure_factor <= pressure)
    return [name for name, each in soft if not any(exponents_of(each))]


def other_wheels(task: Task) -> Sequence[OtherWheel]:
    """Return the wheels of the same abrasive that may run as fast, sorted by catalogue name.

    Another wheel differs from the wheel of the task only in dulling, grain strength, wear and roughness. Price, body
    and grains are those of the task's wheel.
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
