"""The compiled step of `grind/Stroke-v0`: a block of one stroke, which `settling` prices, and what is seen after it."""

from typing import Any, NamedTuple

import numpy as np

from grind_env.control.rules import DEPTH_TOLERANCE
from grind_env.envs.observations import measured_power
from grind_env.envs.observe import scaled
from grind_env.envs.rows import KindRow, Shop, read_kind, read_memory, read_shop, write_memory, write_outcome
from grind_env.envs.settling import PowerReadings, chance, counted_rise, outcome_of, remembered
from grind_env.envs.step import CYCLE_FIELDS, NEW_PART, WEAR, Choices, EpisodeArrays, Tables, write_factored
from grind_env.envs.stroke import rules
from grind_env.envs.stroke.readings import StrokeReadings
from grind_env.envs.stroke.rules import Pace, Table
from grind_env.envs.tape import read_row, write_row
from grind_env.kernel import entry, inlined, inlined_rule
from grind_env.kernel.rows import column_reader, column_writer
from grind_env.machine.batch import NO_MOTIONS, PLUNGES
from grind_env.machine.cycle import Cycle, dress_lead
from grind_env.machine.rows import read_parameters, read_part, read_tally, read_wheel, write_cycle, write_part
from grind_env.machine.tally import NO_PLUNGES, Plunges, count_plunge, mean_last_power
from grind_env.process.cost import Rates, handover_cost

PART, WITHIN, LAST = range(3)
"""The kinds of a task stand in its table as parts, as strokes within one, and as its last stroke, which ends it."""

TOGETHER = 256
"""Strokes made in one go, few enough that their rows stay in a near cache."""

READINGS = len(StrokeReadings._fields)
grind_strokes = PLUNGES.lanes

strokes_of, depth_of, pick_before = map(inlined_rule, (rules.strokes_of, rules.depth_of, rules.pick_before))
stroke_time, setting_out = inlined_rule(rules.stroke_time), inlined_rule(rules.setting_out)
next_turn = inlined_rule(rules.next_turn)


class StrokeMemory(NamedTuple):
    """What is remembered from stroke to stroke besides `rows.Memory`."""

    made: float
    """Strokes made on the part."""
    all_made: float
    """Strokes made in the episode."""
    power: float
    """Highest power on the part, W."""
    rise: float
    """Highest temperature rise on the part that counts, K."""
    clock: float
    """Of `rules.Pace`, in the last stroke, like the next two."""
    began: float
    speed: float


class StrokeArrays(NamedTuple):
    """The state of N episodes beside `EpisodeArrays`, as in `simulation.StrokeEpisodes`."""

    rows: Any
    """Tape of the part in work or coming, at the end of the last one, shape (N, fields of `TapeRow`).

    A copy: rows of episodes at different parts lie scattered on the tape, so that each costs a wait for the memory.
    """
    strokes: Any
    """Shape (N, fields of `StrokeMemory`)."""
    plunges: Any
    """Power readings of the latest full plunges, shape (N, fields of `Plunges`)."""
    parameters: Any
    """Of the part in work, shape (N, fields of `StrokeParameters`)."""


ALL_MADE = StrokeMemory._fields.index("all_made")

read_strokes, write_strokes = column_reader(StrokeMemory), column_writer(StrokeMemory)
read_plunges, write_plunges = column_reader(Plunges), column_writer(Plunges)
write_readings = column_writer(StrokeReadings)


@inlined
def kind_of(kinds: Any, materials: int, material: float, what: int) -> KindRow:
    """The kind of a `PART`, of a stroke `WITHIN` one, or of its `LAST` one."""
    kind: KindRow = read_kind(kinds, what * materials + int(material))
    return kind


@inlined
def cycle_of(kind: KindRow, depth: float, stock: float, E: float, D: float, seconds: float, shop: Shop) -> Cycle:
    """The cycle of one stroke.

    Args:
        kind: of the part.
        depth: of the stroke, mm.
        stock: of the part, mm.
        E: mm/min.
        D: 1 for a dress before it, else 0.
        seconds: time without the dress.
        shop: numbers of the task.
    """
    return Cycle(
        speed=E / 60.0,
        first_seconds=seconds,
        stroke_seconds=seconds,
        start=depth,
        target=depth,
        primary_pick=kind.pick,
        secondary_pick=kind.pick,
        at_depth=1.0,
        executions=0.0,
        pre_dress=D,
        full_plunge=kind.pick - DEPTH_TOLERANCE,
        finish=stock,
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
def prepare_stroke(
    i: int, tables: Tables, episodes: EpisodeArrays, more: StrokeArrays, choices: Choices, cycles: Any
) -> None:
    """Write the cycle of the stroke of episode i, after loading its part if it is the first."""
    kinds, base, shop, materials = tables
    tape, block, wheels, parts, _ = episodes
    E, D = choices.speeds[i], choices.executions[i]
    row, old = read_row(more.rows, i), read_strokes(more.strokes, i)
    kind = kind_of(kinds, materials, row.material, PART)
    table = Table(length=kind.stroke, acceleration=shop.acceleration, dwell=shop.dwell)
    pace, extra = setting_out(E), kind.load
    if old.made > 0.0:
        before = Pace(clock=old.clock, began=old.began, speed=old.speed)
        turn = next_turn(table, before, pick_before(old.made, row.stock, kind.pick), E, D > 0.0)
        pace, extra = turn.pace, turn.wait
    else:
        write_factored(more.parameters, i, base, int(row.material), tape, block[i], False)
        write_part(parts, i, NEW_PART)
        wheels[i, WEAR] = 0.0  # touched off on the new part
    depth = depth_of(old.made, row.stock, kind.pick)
    write_cycle(cycles, i, cycle_of(kind, depth, row.stock, E, D, stroke_time(table, E) + extra, shop))
    new = StrokeMemory(
        made=old.made,
        all_made=old.all_made,
        power=old.power,
        rise=old.rise,
        clock=pace.clock,
        began=pace.began,
        speed=pace.speed,
    )
    write_strokes(more.strokes, i, new)


@inlined
def settle_stroke(
    i: int,
    tables: Tables,
    episodes: EpisodeArrays,
    more: StrokeArrays,
    choices: Choices,
    z: float,
    results: Any,
    outcomes: Any,
) -> None:
    """Write what the stroke of episode i has cost and shown, and go on to the next one or to the next part.

    z is the noise of its power reading.
    """
    kinds, _, shop, materials = tables
    tape, block, wheels, parts, memory = episodes
    E, D = choices.speeds[i], choices.executions[i]
    row, done = read_row(more.rows, i), read_strokes(more.strokes, i)
    result, old, part = read_tally(results, i), read_memory(memory, i), read_part(parts, i)
    whole = kind_of(kinds, materials, row.material, PART)
    last = done.made + 1.0 >= strokes_of(row.stock, whole.pick, whole.sparkout)
    kind = kind_of(kinds, materials, row.material, LAST if last else WITHIN)
    power, counted = max(done.power, result.peak_power), max(done.rise, counted_rise(kind, result))
    size_error = 1000.0 * (row.stock - part.S)
    good = chance(kind, counted, power, part.Rs, size_error)
    # heat of a stroke that later ones grind off is shown, but does not count
    rise = counted if last else result.plunge_rise
    handover = 0.0
    if last and block[i] + 1 == tape.shape[1]:
        wheel, p = read_wheel(wheels, i), read_parameters(more.parameters, i)
        lead, rates = dress_lead(wheel, shop.dress_feed, p), Rates(shop.hourly, shop.wheel_price, shop.dress_price)
        handover = handover_cost(wheel, shop.dress_passes, lead, shop.dress_depth, shop.dress_seconds, p, rates)
    outcome = outcome_of(kind, row, shop, part, result, old, size_error, rise, good, 0.0, handover)
    write_outcome(outcomes, i, outcome)
    reading = measured_power(result.peak_power, z)
    known = NO_PLUNGES if D > 0.0 else read_plunges(more.plunges, i)
    plunges = count_plunge(known, reading, result.first_count > 0.0)
    write_plunges(more.plunges, i, plunges)
    peak = 0.0 if last else max(old.peak_power, reading)
    powers = PowerReadings(mean=mean_last_power(plunges), first=reading, peak=peak)
    volume = pick_before(done.made, row.stock, kind.pick) * kind.length
    write_memory(memory, i, remembered(kind, row, result, old, powers, outcome, good, 0.0, E, D, D, volume))
    made, power, counted = (0.0, 0.0, 0.0) if last else (done.made + 1.0, power, counted)
    new = StrokeMemory(
        made=made,
        all_made=done.all_made + 1.0,
        power=power,
        rise=counted,
        clock=done.clock,
        began=done.began,
        speed=done.speed,
    )
    write_strokes(more.strokes, i, new)
    if last:
        block[i] += 1
        if block[i] < tape.shape[1]:
            write_row(more.rows, i, read_row(tape[i], block[i]))


@entry
def step_strokes(
    kinds: Any,
    base: Any,
    shops: Any,
    tape: Any,
    block: Any,
    wheels: Any,
    parts: Any,
    memory: Any,
    rows: Any,
    strokes: Any,
    plunges: Any,
    parameters: Any,
    noise: Any,
    speeds: Any,
    executions: Any,
    materials: int,
    active: Any,
    results: Any,
    outcomes: Any,
) -> None:
    """Make the next stroke of the episodes in `active`.

    Args:
        kinds: as for `envs.step.step_blocks`, but three times: `PART`, `WITHIN` and `LAST`.
        base: as for `step_blocks`, like the next six.
        shops: numbers of the task.
        tape: noise tape; a row a part.
        block: number of the part in work or coming; updated.
        wheels: updated.
        parts: updated.
        memory: updated.
        rows: of `StrokeArrays`, like the next three; updated.
        strokes: updated.
        plunges: updated.
        parameters: updated.
        noise: of the power reading of every stroke, standard normal times a factor, shape (N, strokes).
        speeds: E, mm/min.
        executions: 1 for a dress before the stroke, else 0.
        materials: number of materials in the tables.
        active: indices of the episodes to step, int64.
        results: shape (N, fields of `Tally`); written in the rows of `active`.
        outcomes: shape (N, fields of `Outcome`); written likewise.
    """
    tables = Tables(kinds, base, read_shop(shops, 0), materials)
    episodes = EpisodeArrays(tape, block, wheels, parts, memory)
    more = StrokeArrays(rows, strokes, plunges, parameters)
    choices = Choices(speeds, executions, executions)
    cycles = np.empty((block.size, CYCLE_FIELDS))
    z = np.empty(TOGETHER)
    for first in range(0, active.size, TOGETHER):
        some = active[first : first + TOGETHER]
        # in a loop with nothing else in it, since every number lies where the memory has to be waited for
        for k in range(some.size):
            z[k] = noise[some[k], int(strokes[some[k], ALL_MADE])]
        for i in some:
            prepare_stroke(i, tables, episodes, more, choices, cycles)
        grind_strokes(cycles, parameters, wheels, parts, results, NO_MOTIONS, some, 0, 1)
        for k in range(some.size):
            settle_stroke(some[k], tables, episodes, more, choices, z[k], results, outcomes)


@inlined
def observe_stroke(
    i: int,
    kinds: Any,
    materials: int,
    parts: int,
    block: Any,
    wheels: Any,
    memory: Any,
    rows: Any,
    strokes: Any,
    offset: Any,
    scale: Any,
    low: Any,
    high: Any,
    values: Any,
    observations: Any,
) -> None:
    """Write the observation of episode i; `values`, shape (1, fields of `StrokeReadings`), is overwritten."""
    ahead = block[i] < parts
    row, done = read_row(rows, i), read_strokes(strokes, i)
    wheel, seen = read_wheel(wheels, i), read_memory(memory, i)
    kind = kind_of(kinds, materials, row.material, PART)
    here = 1.0 if ahead else 0.0
    left = strokes_of(row.stock, kind.pick, kind.sparkout) - done.made
    starts = 1.0 if done.made == 0.0 else 0.0
    # without a coming part the entry itself is 0: a stock of nominal size
    stock = row.gauged / kind.stock if ahead else 1.0
    reading = StrokeReadings(
        power=seen.first_power,
        mean_power=seen.mean_power,
        peak_power=seen.peak_power,
        last_speed=seen.speed,
        last_dress=seen.executions,
        size_error=seen.size_error,
        roughness=seen.roughness,
        parts_since_gauged=seen.since_gauged,
        volume=seen.volume,
        dresses=seen.dresses,
        diameter=wheel.ds,
        pick=here * pick_before(done.made, row.stock, kind.pick),
        strokes_left=here * left,
        stock=stock,
        starts_part=here * starts,
        new_lot=here * row.new_lot,
        remaining=(parts - block[i]) / parts,
        wear_flat=wheel.A,
        loading=wheel.lam,
        waviness=wheel.alw,
        diamond_flat=wheel.wd,
        wheel_volume=wheel.V,
        growth=row.kA,
        pressure=row.pm,
    )
    write_readings(values, 0, reading)
    for k in range(observations.shape[1]):
        observations[i, k] = scaled(values[0, k], offset[k], scale[k], low[k], high[k])


@entry
def observe_strokes(
    kinds: Any,
    materials: int,
    parts: int,
    block: Any,
    wheels: Any,
    memory: Any,
    rows: Any,
    strokes: Any,
    offset: Any,
    scale: Any,
    low: Any,
    high: Any,
    observations: Any,
) -> None:
    """Write the observations before the coming strokes.

    Args:
        kinds: as for `step_strokes`, like `materials` and the arrays of N rows.
        materials: number of materials in the tables.
        parts: of an episode.
        block: number of the coming part.
        wheels: wheel states.
        memory: what is remembered.
        rows: tapes of the coming parts.
        strokes: what is remembered beside.
        offset: of each entry, shape (entries,), like the next three.
        scale: of each entry.
        low: of each entry.
        high: of each entry.
        observations: shape (N, entries), float32; written.
    """
    values = np.empty((1, READINGS))
    for i in range(block.size):
        observe_stroke(
            i,
            kinds,
            materials,
            parts,
            block,
            wheels,
            memory,
            rows,
            strokes,
            offset,
            scale,
            low,
            high,
            values,
            observations,
        )
