"""The step of `grind/Stroke-v0`: a block of one stroke, which `settling` prices, and what is seen after it."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

from grind_env.control.cycles.plunge import PlungeCycle
from grind_env.envs.blocks.settling import (
    booked_diameter,
    chance,
    counted_rise,
    handover_of,
    noise_of,
    outcome_of,
    remembered,
    truth_of,
    with_powers,
)
from grind_env.envs.blocks.step import (
    DIAMETER,
    NEW_PART,
    WEAR,
    Choices,
    draw_coming,
    stroking_of,
    write_factored,
    write_plunge,
)
from grind_env.envs.drawing import STROKE, deviation, words_of
from grind_env.envs.step import Work, step_of
from grind_env.envs.strokes import rules
from grind_env.envs.strokes.rules import Pace, TableRun
from grind_env.envs.tables import (
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
from grind_env.envs.tape import BLOCKS, KEY_0, KEY_1, NOISE_FACTOR, TapeRow, place_of, read_row, read_sigmas
from grind_env.kernel import entry, inlined, inlined_rule
from grind_env.kernel.columns import column_reader, column_writer, replacer
from grind_env.machine.loops.batch import NO_MOTIONS
from grind_env.machine.loops.courses import COURSES
from grind_env.machine.loops.cycle import dress_lead
from grind_env.machine.loops.loops import loops_of
from grind_env.machine.loops.rows import (
    OWN_FROM,
    read_parameters,
    read_part,
    read_tally,
    read_wheel,
    write_part,
    write_stroking,
)
from grind_env.machine.loops.shift import shift_of
from grind_env.machine.loops.tally import NO_PLUNGES, Plunges, Tally, count_plunge, mean_last_power
from grind_env.process.cost import STALL
from grind_env.process.gauge import Gauge, Shown
from grind_env.process.process import Drive, Moment, Process, joined

PART, WITHIN, LAST = range(3)
"""The kinds of a task stand in its table as parts, as strokes within one, and as its last stroke, which ends it."""

TOGETHER = 256
"""Strokes made in one go, few enough that their rows stay in a near cache."""

strokes_of, depth_of, pick_before = map(inlined_rule, (rules.strokes_of, rules.depth_of, rules.pick_before))
stroke_time, setting_out = inlined_rule(rules.stroke_time), inlined_rule(rules.setting_out)
next_turn = inlined_rule(rules.next_turn)


class StrokeMemory(NamedTuple):
    """What is remembered from stroke to stroke besides `rows.Memory`."""

    made: float
    """Strokes made on the part."""
    all_made: float
    """Strokes made in the episode."""
    torque: float
    """Highest torque on the part over that at which the spindle stalls."""
    rise: float
    """Highest temperature rise on the part that counts, K."""
    noise: float
    """Of the power reading of the coming stroke, once it is prepared; no unit."""
    share: float
    """Of every E that the table reaches on the part, like the next one once its first stroke is prepared."""
    dwell: float
    """At a reversal point, s."""


class StrokeTables(NamedTuple):
    """What the task is made of, and room for N cycles; as in `Tables`, but the parameters are of the episodes.

    The kinds stand in it three times: `PART`, `WITHIN` and `LAST`.
    """

    kinds: Any
    base: Any
    shops: Any
    drawn: Any
    spreads: Any
    cycles: Any


class StrokeArrays(NamedTuple):
    """The state of N episodes, as in `simulation.StrokeEpisodes`; the first seven as in `EpisodeArrays`."""

    tape: Any
    block: Any
    wheels: Any
    parts: Any
    memory: Any
    source: Any
    schedule: Any
    strokes: Any
    """Shape (N, fields of `StrokeMemory`)."""
    paces: Any
    """In the last stroke, shape (N, fields of `Pace`)."""
    plunges: Any
    """Power readings of the latest full plunges, shape (N, fields of `Plunges`)."""
    parameters: Any
    """Of the part in work, shape (N, fields of `StrokeParameters`)."""


TORQUE, CLOCK = Tally._fields.index("peak_torque"), ShopMemory._fields.index("clock")
ALL_MADE, NOISE = StrokeMemory._fields.index("all_made"), StrokeMemory._fields.index("noise")

read_strokes, write_strokes = column_reader(StrokeMemory), column_writer(StrokeMemory)
read_pace, write_pace = column_reader(Pace), column_writer(Pace)
read_plunges, write_plunges = column_reader(Plunges), column_writer(Plunges)
read_drive = column_reader(Drive, StrokeMemory._fields.index("share"))
write_drive = column_writer(Drive, StrokeMemory._fields.index("share"))
with_noise = replacer(Shown, "peak_power")
gone_on = replacer(StrokeMemory, "made", "all_made", "torque", "rise", "noise")


@inlined
def row_in_work(tape: Any, block: Any, parts: int, i: int) -> TapeRow:
    """The row of the part in work or coming of episode i, at the end that of the last one of so many `parts`."""
    row: TapeRow = read_row(tape[i], place_of(min(block[i], parts - 1), tape.shape[1]))
    return row


@inlined
def kind_of(kinds: Any, materials: int, material: float, what: int) -> KindRow:
    """The kind of a `PART`, of a stroke `WITHIN` one, or of its `LAST` one."""
    kind: KindRow = read_kind(kinds, what * materials + int(material))
    return kind


@functools.cache
def strokes_step(process: Process, gauge: Gauge) -> Callable[..., None]:
    """The compiled step of single strokes."""
    (pass_time, before), read, own = shift_of(process), gauge.read, joined(process.own, gauge.own)
    read_own, write_own = column_reader(own, OWN_FROM), column_writer(own, OWN_FROM)
    grind_strokes = loops_of(COURSES["G82"], process).lanes

    @inlined
    def prepare_stroke(
        i: int, tables: StrokeTables, episodes: StrokeArrays, E: float, D: float, shop: Shop, results: Any
    ) -> None:
        """Write the cycle of the stroke of episode i, after loading its part if it is the first.

        In its result, a spindle that has stalled on the part is noted.
        """
        place = place_of(episodes.block[i], episodes.tape.shape[1])
        row, done = read_row(episodes.tape[i], place), read_strokes(episodes.strokes, i)
        made = done.made
        results[i, TORQUE] = done.torque if done.torque >= STALL else 0.0
        kind = kind_of(tables.kinds, int(shop.materials), row.material, PART)
        wheels, parameters = episodes.wheels, episodes.parameters
        if made == 0.0:
            write_factored(parameters, i, tables.base, int(row.material), episodes.tape, place, False)
            write_part(episodes.parts, i, NEW_PART)
            pass_time(wheels, parameters, i, kind.wait, True)
            wheels[i, WEAR] = 0.0  # touched off on the new part
            number, clock = float(episodes.block[i]), episodes.memory[i, CLOCK] + kind.wait
            moment = Moment(number=number, seconds=clock, place=0.5 * kind.length, E=E)
            write_drive(episodes.strokes, i, before(wheels, parameters, i, shop.dwell, moment))
        drive = read_drive(episodes.strokes, i)
        table = TableRun(length=kind.stroke, acceleration=shop.acceleration, dwell=drive.dwell)
        reached, waited = drive.share * E, kind.wait
        if made > 0.0:
            pick = pick_before(made, row.stock, kind.pick)
            turn = next_turn(table, read_pace(episodes.paces, i), pick, reached, D > 0.0)
            write_pace(episodes.paces, i, turn.pace)
            waited = turn.wait
            pass_time(wheels, parameters, i, waited, False)
        else:
            write_pace(episodes.paces, i, setting_out(reached))
        episodes.memory[i, FOUND] = wheels[i, DIAMETER]
        depth, seconds = depth_of(made, row.stock, kind.pick), stroke_time(table, reached)
        write_stroking(tables.cycles, i, stroking_of(kind, shop, reached, seconds, waited, depth, depth, row.stock))
        picks = PlungeCycle(
            depth=0.0, primary_pick=kind.pick, secondary_pick=kind.pick, at_depth=1.0, executions=0.0, pre_dress=D
        )
        write_plunge(tables.cycles, i, picks)

    @inlined
    def settle_stroke(
        i: int,
        tables: StrokeTables,
        episodes: StrokeArrays,
        E: float,
        D: float,
        shop: Shop,
        results: Any,
        outcomes: Any,
    ) -> None:
        """Write what the stroke of episode i has cost and shown, and go on to the next one or to the next part."""
        kinds, materials = tables.kinds, int(shop.materials)
        tape, block = episodes.tape, episodes.block
        row, done = read_row(tape[i], place_of(block[i], tape.shape[1])), read_strokes(episodes.strokes, i)
        result, old, part = read_tally(results, i), read_memory(episodes.memory, i), read_part(episodes.parts, i)
        kind = kind_of(kinds, materials, row.material, PART)
        last = done.made + 1.0 >= strokes_of(row.stock, kind.pick, kind.sparkout)
        kind = kind_of(kinds, materials, row.material, LAST if last else WITHIN)
        torque, counted = max(done.torque, result.peak_torque), max(done.rise, counted_rise(kind, result))
        size_error = 1000.0 * (row.stock - part.S)
        # later strokes grind off what is rough and what is left
        good = chance(kind, counted, torque, part.Rs, size_error) if last else chance(kind, counted, torque, 0.0, 0.0)
        # heat that later strokes grind off is shown, but does not count
        rise = counted if last else result.plunge_rise
        handover, wheel = 0.0, read_wheel(episodes.wheels, i)
        if last and block[i] + 1 == episodes.source[i, BLOCKS]:
            p = read_parameters(episodes.parameters, i)
            handover = handover_of(wheel, dress_lead(wheel, shop.dress_feed, p), shop, p)
        outcome = outcome_of(kind, row, shop, part, result, old, size_error, rise, good, 0.0, handover)
        write_outcome(outcomes, i, outcome)
        truth, clock = truth_of(result, outcome, wheel.ds), old.clock + outcome.seconds
        noise = with_noise(noise_of(row), (done.noise,))
        shown, own = read(truth, read_own(episodes.wheels, i), clock, noise)
        write_own(episodes.wheels, i, own)
        reading = shown.peak_power
        known = NO_PLUNGES if D > 0.0 else read_plunges(episodes.plunges, i)
        latest = count_plunge(known, reading, result.first_count > 0.0)
        write_plunges(episodes.plunges, i, latest)
        peak = 0.0 if last else max(old.peak_power, reading)
        shown = with_powers(shown, (mean_last_power(latest), reading, peak))
        volume = pick_before(done.made, row.stock, kind.pick) * kind.length
        off = 2.0 * result.dresses * shop.dress_passes * shop.dress_depth
        # the wheel is touched off on the next part
        diameter = booked_diameter(shown, shop, old, off, last, 0.0)
        new_memory = remembered(kind, result, old, shown, outcome, good, 0.0, E, D, D, volume, diameter)
        write_memory(episodes.memory, i, new_memory)
        made, torque, counted = (0.0, 0.0, 0.0) if last else (done.made + 1.0, torque, counted)
        write_strokes(episodes.strokes, i, gone_on(done, (made, done.all_made + 1.0, torque, counted, 0.0)))
        block[i] += 1 if last else 0

    @entry
    def prepare(tables: StrokeTables, episodes: StrokeArrays, choices: Choices, active: Any, results: Any) -> None:
        """Write the cycles of the coming strokes; D is their pre-dress."""
        shop, sigmas = read_shop(tables.shops, 0), read_sigmas(tables.spreads, 0)
        strokes, source = episodes.strokes, episodes.source
        for i in active:
            word, _, _, _ = words_of(source[i, KEY_0], source[i, KEY_1], STROKE, int(strokes[i, ALL_MADE]))
            strokes[i, NOISE] = deviation(source[i, NOISE_FACTOR] * sigmas.measurement, word)
            prepare_stroke(i, tables, episodes, choices.speeds[i], choices.executions[i], shop, results)

    @entry
    def grind(tables: StrokeTables, episodes: StrokeArrays, choices: Choices, active: Any, results: Any) -> None:
        """Make the strokes."""
        grind_strokes(
            tables.cycles, episodes.parameters, episodes.wheels, episodes.parts, results, NO_MOTIONS, active, 0, 1
        )

    @entry
    def settle(
        tables: StrokeTables, episodes: StrokeArrays, choices: Choices, active: Any, results: Any, outcomes: Any
    ) -> None:
        """Write what they have cost and shown."""
        shop = read_shop(tables.shops, 0)
        for i in active:
            settle_stroke(i, tables, episodes, choices.speeds[i], choices.executions[i], shop, results, outcomes)
        draw_coming(tables, episodes, active)

    return step_of(Work(StrokeTables, StrokeArrays, Choices, prepare, grind, settle, TOGETHER))
