"""Parts that are alike keep alike words: what their blocks say in the same words is searched as one value."""

from collections.abc import Iterable
from dataclasses import replace
from typing import TypeAlias

from grind_env.envs.job.simulation import JobSimulation
from grind_env.shop.optimise.spots import Spot
from grind_env.shop.optimise.variables import SearchVariable

Likeness: TypeAlias = tuple[object, ...]


def together(variables: Iterable[SearchVariable], simulation: JobSimulation) -> tuple[SearchVariable, ...]:
    """The variables, those of the same word in blocks of different parts that are alike made one.

    Blocks are alike that are the same place in the order of their part, make the same strokes to the same depth, say
    the same, and grind a part of which the same is asked.
    """
    kinds = _kinds(simulation)
    found: dict[Likeness, SearchVariable] = {}
    for each in variables:
        # a dress program is one of its own, whatever blocks it dresses in
        place = "" if isinstance(each.at, Spot) else each.place
        alike = place, each.name, each.own, each.unit, each.levels, frozenset(kinds[number] for number in each.blocks)
        first = found.get(alike)
        found[alike] = each if first is None else _joined(first, each)
    return tuple(found.values())


def _joined(one: SearchVariable, other: SearchVariable) -> SearchVariable:
    return replace(one, blocks=(*one.blocks, *other.blocks), twins=(*one.twins, other))


def _kinds(simulation: JobSimulation) -> list[Likeness]:
    """Of each block: its number within its part, its strokes, and the part wherever it lies."""
    count: dict[int, int] = {}
    kinds: list[Likeness] = []
    for block in simulation.blocks:
        number = count[block.part] = count.get(block.part, 0) + 1
        plan, job = block.plan, simulation.job.of_part(block.part + 1)
        depth = round(abs(plan.depth_target - plan.plunge_start), 6)
        strokes = plan.code, round(abs(plan.primary - plan.secondary), 6), depth, round(block.depth, 6), plan.spark_out
        said = plan.feed, plan.dresses, plan.primary_pick, plan.secondary_pick
        kinds.append((number, strokes, said, replace(job.part, start=0.0, across=0.0, surface=0.0)))
    return kinds
