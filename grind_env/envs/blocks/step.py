"""The compiled step: cycle parameters from E and D, the block kernel, and what `settling` says of it."""

from typing import Any, NamedTuple

import numpy as np

from grind_env.belief.hidden import FACTORS
from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.envs.blocks.settling import (
    booked_diameter,
    counted_rise,
    good_so_far,
    handover_of,
    outcome_of,
    power_readings,
    remembered,
)
from grind_env.envs.blocks.tables import (
    FOUND,
    KindRow,
    Shop,
    ShopMemory,
    read_kind,
    read_memory,
    read_shop,
    write_memory,
    write_outcome,
)
from grind_env.envs.blocks.tape import SPARE_FACTORS, TapeRow, read_row
from grind_env.kernel import entry, inlined
from grind_env.machine.batch import NO_MOTIONS, PLUNGES, longest_first
from grind_env.machine.cycle import Cycle, PartState, dress_lead
from grind_env.machine.rows import (
    read_parameters,
    read_part,
    read_tally,
    read_wheel,
    write_cycle,
    write_part,
    write_wheel,
)
from grind_env.machine.rules import motion_time
from grind_env.machine.tally import Tally
from grind_env.process.cost import STALL
from grind_env.process.equations import INITIAL_ROUGHNESS
from grind_env.process.state import StrokeParameters, WheelState
from grind_env.process.stroke import dressed_wheel

DIAMETER, WEAR = WheelState._fields.index("ds"), WheelState._fields.index("W")
TARGET = Cycle._fields.index("target")
FACTOR_COLUMNS = tuple(TapeRow._fields.index(name) for name in FACTORS)
SPARE_COLUMNS = tuple(TapeRow._fields.index(name) for name in SPARE_FACTORS)
PARAMETER_COLUMNS = tuple(StrokeParameters._fields.index(name) for name in FACTORS)
CHANGES = ShopMemory._fields.index("wheel_changes")
STALLED, TORQUE = ShopMemory._fields.index("stalled"), Tally._fields.index("peak_torque")
CYCLE_FIELDS = len(Cycle._fields)
NEW_PART = PartState(Z=0.0, S=0.0, Rs=INITIAL_ROUGHNESS)
grind_plunges = PLUNGES.lanes


class Tables(NamedTuple):
    """What a task is made of."""

    kinds: Any
    """Of `rows.kind_table`, shape (kinds x materials, fields of `KindRow`)."""
    base: Any
    """Of `rows.parameter_table`, shape (kinds x materials, fields of `StrokeParameters`)."""
    shop: Shop
    materials: int
    """Number of materials in the two tables."""


class EpisodeArrays(NamedTuple):
    """The state of N episodes, as in `simulation.Episodes`. All but the tape is updated by a step."""

    tape: Any
    """Shape (N, blocks, fields of `TapeRow`)."""
    block: Any
    """Number of the coming block, shape (N,), int64."""
    wheels: Any
    """Shape (N, fields of `WheelState`)."""
    parts: Any
    """Shape (N, fields of `PartState`)."""
    memory: Any
    """Shape (N, fields of `ShopMemory`)."""


class Choices(NamedTuple):
    """What is chosen for the coming block of N episodes, each shape (N,)."""

    speeds: Any
    """E, mm/min."""
    executions: Any
    """D."""
    pre_dresses: Any
    """1 for a dress before the first plunge, else 0."""


@inlined
def cycle_of(
    kind: KindRow, row: TapeRow, part: PartState, E: float, D: float, shop: Shop, pre_dress: float = 0.0
) -> Cycle:
    """The cycle of a block.

    The wheel is set to the first depth before the first stroke, off the part, so the cycle itself makes one
    pick less than there are depths, and one spark-out stroke more follows its last cut.
    """
    surface = 0.0 if kind.starts_part > 0.0 else part.Z
    seconds = motion_time(kind.stroke, E / 60.0, shop.acceleration) + shop.dwell
    target = surface + row.stock
    start = min(surface + kind.pick, target)
    return plunge_cycle(kind, shop, E, seconds, start, target, target, kind.sparkout + 2.0, D, pre_dress)


@inlined
def plunge_cycle(
    kind: KindRow,
    shop: Shop,
    E: float,
    seconds: float,
    start: float,
    target: float,
    finish: float,
    at_depth: float,
    D: float,
    pre_dress: float,
) -> Cycle:
    """A cycle of strokes of some seconds at E (mm/min), with the picks of a kind; the others as in `Cycle`."""
    return Cycle(
        speed=E / 60.0,
        first_seconds=seconds,
        stroke_seconds=seconds,
        start=start,
        target=target,
        surface=0.0,
        bottom=start + (target - start),
        primary_pick=kind.pick,
        secondary_pick=kind.pick,
        at_depth=at_depth,
        executions=D,
        pre_dress=pre_dress,
        full_plunge=kind.pick - DEPTH_TOLERANCE,
        finish=finish,
        width=kind.width,
        length=kind.length,
        dress_passes=shop.dress_passes,
        dress_feed=shop.dress_feed,
        dress_depth=shop.dress_depth,
        dress_seconds=shop.dress_seconds,
        cross_start=0.0,
        cross_end=0.0,
        primary_cross_pick=0.0,
        secondary_cross_pick=0.0,
    )


@inlined
def write_factored(parameters: Any, i: int, base: Any, number: int, tape: Any, block: int, changed: bool) -> None:
    """Write row `number` of the nominal parameters to episode i, with the factors of a block on its tape.

    Those of the spare wheel, if the wheel has been changed.
    """
    # a loop: with numba's copy of a slice, all of `prepare` takes 40 % longer
    for k in range(base.shape[1]):
        parameters[i, k] = base[number, k]
    for k in range(len(FACTOR_COLUMNS)):
        column = SPARE_COLUMNS[k] if changed else FACTOR_COLUMNS[k]
        parameters[i, PARAMETER_COLUMNS[k]] *= tape[i, block, column]


@inlined
def prepare_block(
    i: int, tables: Tables, episodes: EpisodeArrays, choices: Choices, cycles: Any, parameters: Any, results: Any
) -> None:
    """Write the cycle of the block of episode i; arguments as for `prepare`."""
    kinds, base, shop, materials = tables
    tape, block, wheels, parts, memory = episodes
    speeds, executions, pre_dresses = choices
    row = read_row(tape[i], block[i])
    number = int(row.kind) * materials + int(row.material)
    kind = read_kind(kinds, number)
    cycle = cycle_of(kind, row, read_part(parts, i), speeds[i], executions[i], shop, pre_dresses[i])
    write_cycle(cycles, i, cycle)
    write_factored(parameters, i, base, number, tape, block[i], memory[i, CHANGES] > 0.0)
    memory[i, FOUND] = wheels[i, DIAMETER]
    # the part is touched off or gauged before every block: wear of the wheel up to now is known
    wheels[i, WEAR] = 0.0
    results[i, TORQUE] = 0.0 if kind.starts_part > 0.0 else memory[i, STALLED] * STALL
    if kind.starts_part > 0.0:
        write_part(parts, i, NEW_PART)


@entry
def prepare(
    tables: Tables,
    episodes: EpisodeArrays,
    choices: Choices,
    active: Any,
    cycles: Any,
    parameters: Any,
    results: Any,
) -> None:
    """Write the cycle of every block and its parameters, and load or gauge the parts.

    Args:
        tables: of the task.
        episodes: their wheels and parts are updated.
        choices: for the coming blocks.
        active: indices of the episodes to step, int64.
        cycles: shape (N, fields of `Cycle`); written in the rows of `active`.
        parameters: shape (N, fields of `StrokeParameters`); written likewise.
        results: shape (N, fields of `Tally`), all 0; a part on which the spindle has stalled is noted.
    """
    for i in active:
        prepare_block(i, tables, episodes, choices, cycles, parameters, results)


@inlined
def settle_block(
    i: int,
    tables: Tables,
    episodes: EpisodeArrays,
    choices: Choices,
    cycles: Any,
    parameters: Any,
    results: Any,
    outcomes: Any,
) -> None:
    """Write what the block of episode i has cost and shown; arguments as for `settle`."""
    kinds, _, shop, materials = tables
    tape, block, wheels, parts, memory = episodes
    speeds, executions, pre_dresses = choices
    row = read_row(tape[i], block[i])
    kind = read_kind(kinds, int(row.kind) * materials + int(row.material))
    wheel, part, p = read_wheel(wheels, i), read_part(parts, i), read_parameters(parameters, i)
    result, old = read_tally(results, i), read_memory(memory, i)
    lead = dress_lead(wheel, shop.dress_feed, p)
    change = 1.0 if wheel.ds < shop.least_diameter else 0.0
    if change > 0.0:
        wheel = dressed_wheel(shop.new_diameter, wheel.wd, lead, shop.dress_depth, p)
        write_wheel(wheels, i, wheel)
    handover = 0.0
    if block[i] + 1 == tape.shape[1]:
        handover = handover_of(wheel, lead, shop, p)
    size_error = 1000.0 * (cycles[i, TARGET] - part.S)
    good = good_so_far(kind, part, result, size_error, old)
    rise = counted_rise(kind, result)
    outcome = outcome_of(kind, row, shop, part, result, old, size_error, rise, good, change, handover)
    write_outcome(outcomes, i, outcome)
    powers = power_readings(row, result, change)
    E, D, pre_dress = speeds[i], executions[i], pre_dresses[i]
    # the executions stand evenly in the depth: an equal share of it is ground after the last one
    volume = row.gauged * kind.length / (result.dresses - pre_dress + 1.0)
    # the next block begins with touching off or gauging
    diameter = booked_diameter(wheel, row, shop, old, 0.0, True, change)
    new = remembered(kind, row, result, old, powers, outcome, good, change, E, D, pre_dress, volume, diameter)
    write_memory(memory, i, new)
    block[i] += 1


@entry
def settle(
    tables: Tables,
    episodes: EpisodeArrays,
    choices: Choices,
    active: Any,
    cycles: Any,
    parameters: Any,
    results: Any,
    outcomes: Any,
) -> None:
    """Write what the blocks that were run have cost and shown, and go on to the next ones.

    Args:
        tables: as for `prepare`, like the next five.
        episodes: their wheels, memory and block numbers are updated.
        choices: for the blocks that were run.
        active: indices of the episodes to step.
        cycles: of the blocks.
        parameters: of the blocks.
        results: shape (N, fields of `Tally`).
        outcomes: shape (N, fields of `Outcome`); written in the rows of `active`.
    """
    for i in active:
        settle_block(i, tables, episodes, choices, cycles, parameters, results, outcomes)


@entry
def step_blocks(
    cycles: Any,
    parameters: Any,
    kinds: Any,
    base: Any,
    shops: Any,
    tape: Any,
    block: Any,
    wheels: Any,
    parts: Any,
    memory: Any,
    speeds: Any,
    executions: Any,
    pre_dresses: Any,
    materials: int,
    active: Any,
    results: Any,
    outcomes: Any,
) -> None:
    """Grind the next block of the episodes in `active`.

    The arrays come one by one: Python hands over one named tuple of three arrays (0.88 us) no faster than fourteen
    arrays (0.84 us). They are described at `Tables`, `EpisodeArrays` and `Choices`.

    Args:
        cycles: room for the cycles, shape (N, fields of `Cycle`).
        parameters: room for their parameters, shape (N, fields of `StrokeParameters`).
        kinds: of `Tables`, like the next one.
        base: nominal parameters.
        shops: numbers of the task, shape (1, fields of `Shop`).
        tape: of `EpisodeArrays`, like the next four.
        block: number of the coming block; updated.
        wheels: updated.
        parts: updated.
        memory: updated.
        speeds: of `Choices`, like the next two.
        executions: D.
        pre_dresses: 1 for a dress before the first plunge.
        materials: number of materials in the two tables.
        active: indices of the episodes to step, int64.
        results: shape (N, fields of `Tally`); written in the rows of `active`.
        outcomes: shape (N, fields of `Outcome`); written likewise.
    """
    tables = Tables(kinds, base, read_shop(shops, 0), materials)
    episodes = EpisodeArrays(tape, block, wheels, parts, memory)
    choices = Choices(speeds, executions, pre_dresses)
    prepare(tables, episodes, choices, active, cycles, parameters, results)
    order = np.empty(active.size, np.int64)
    longest_first(cycles, active, order)
    grind_plunges(cycles, parameters, wheels, parts, results, NO_MOTIONS, order, 0, 1)
    settle(tables, episodes, choices, active, cycles, parameters, results, outcomes)
