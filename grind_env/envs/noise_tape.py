"""The noise tape of an episode: one row of random numbers for each block, drawn when the block comes up.

Every random number of an episode is a function of the episode's key, of a counter (of a block, an order, a date or a
part) and of its purpose. So the same seed means the same stock, lots, wheels and measurement noise for every policy,
and policies are compared on common random numbers. Factors without spread in a task are not drawn, and the other
numbers do not change.
"""

from typing import Any, NamedTuple

import numpy as np

from grind_env.envs.distribution_splits import Draws
from grind_env.envs.random_numbers import (
    DATE,
    EPISODE,
    LANES,
    LANES_SIZE,
    Block,
    Drawn,
    draw_lanes,
    factor,
    key_of,
    log_normal,
    read_block,
    read_drawn,
    spread,
    unless,
    words_of,
    write_block,
)
from grind_env.envs.reset_options import Fixed
from grind_env.envs.tasks.unseen_entries import OtherWheel
from grind_env.kernel import entry, exp, inlined
from grind_env.kernel.random import uniform
from grind_env.kernel.row_accessors import column_reader, column_writer


class TapeRow(NamedTuple):
    """Random numbers of one block on the tape; noise is standard normal times `Spread.measurement`."""

    kind: float  #: index of the block kind
    stock: float  #: True stock, mm, on the resolution of the control (1 um)
    gauged: float  #: pre-gauged stock, mm
    new_lot: float  #: 1 if the part begins a new lot
    kA: float  #: factor on the wear-flat growth
    pm: float  #: factor on the wear-flat pressure
    hf: float  #: factor on the convection
    fc: float  #: factor on the fracture force
    Gref: float  #: factor on the G-ratio
    ra_scale: float  #: factor on the roughness, of wheel and part
    part_ra: float  #: factor on the roughness, of the part alone
    mean_noise: float  #: noise of the mean power, both relative and absolute; no unit
    first_noise: float  #: noise of the first power; no unit
    peak_noise: float  #: noise of the peak power; no unit
    size_noise: float  #: noise of the size gauge; no unit
    roughness_noise: float  #: noise of the roughness gauge; no unit
    wheel_noise: float  #: noise of the gauged wheel diameter; no unit
    material: float  #: index of the material among `catalogue.materials`
    #: the factor `kA` after a wheel change; every wheel after the first has the factors of the spare wheel
    spare_kA: float
    spare_ra_scale: float  #: the factor `ra_scale` after a wheel change
    due: float  #: next due date, s after the start of the episode; 0 in a task without due dates
    work: float  #: nominal time of this block and of the later blocks up to the next due date, s
    is_due: float  #: 1 for the last block before a due date


#: fields of `TapeRow` with the factors `FACTORS` after a wheel change
SPARE_FACTORS = ("spare_kA", "pm", "hf", "fc", "Gref", "spare_ra_scale")

read_row, write_row = column_reader(TapeRow), column_writer(TapeRow)


AHEAD = 2  #: number of rows of a short tape: for the coming block, and for the next block, whose kind is observed, too


@inlined
def place_of(block: int, rows: int) -> int:
    """Return the row of a block on a tape of `rows` rows; the two rows of a short tape take turns."""
    return block & 1 if rows == AHEAD else block


class Origin(NamedTuple):
    """Inputs from which the rows of an episode are drawn.

    `material`, an index, and the factors `stock`, `kA`, `pm`, `ra_scale` and `slack` are those of `contexts.Fixed`: NaN
    if drawn. `key_0` and `key_1` have no units.
    """

    key_0: float
    key_1: float
    blocks: float  #: number of blocks after which the episode ends
    drawn: float  #: number of rows drawn so far
    ranges: float  #: ranges of the split: bit k for the range of index k; 0 for all ranges
    reach: float  #: factor on the logarithmic standard deviations of wear and pressure
    stocks: float  #: factor on the stock of every part that is not fixed
    material: float
    stock: float
    kA: float
    pm: float
    ra_scale: float
    slack: float
    noise: float  #: factor on the noise, from the context or else from the split
    wheel_kA: float  #: factor of the first wheel on the wear-flat growth
    spare_kA: float  #: factor of every later wheel on the wear-flat growth
    wheel_ra: float  #: factor of the first wheel on the roughness
    spare_ra: float  #: factor of every later wheel on the roughness
    hf: float  #: factor on the convection of the coolant at the start
    ageing: float  #: log of the convection lost with every part, no unit
    fc: float  #: factor on the fracture force
    Gref: float  #: factor on the G-ratio


class Carried(NamedTuple):
    """Values passed from the last drawn row to the next."""

    kA: float  #: factor of the lot on the wear-flat growth
    pm: float  #: factor of the lot on the wear-flat pressure
    part_ra: float  #: factor of the part on the roughness
    parts: float  #: number of parts begun after the first
    due: float  #: next due date, s
    stock: float  #: stock of the part, mm


#: number of columns of the table of sources: the fields of `Origin`, followed by the fields of `Carried`
SOURCE = len(Origin._fields) + len(Carried._fields)
KEY_0, KEY_1, BLOCKS, DRAWN, NOISE_FACTOR = (
    Origin._fields.index(name) for name in ("key_0", "key_1", "blocks", "drawn", "noise")
)
read_origin, write_origin = column_reader(Origin), column_writer(Origin)
read_carried = column_reader(Carried, len(Origin._fields))
write_carried = column_writer(Carried, len(Origin._fields))


class DrawnKind(NamedTuple):
    """Numbers of a block kind from which its tape rows are drawn."""

    stock: float  #: nominal stock, mm
    least_stock: float  #: smallest ratio of drawn stock to nominal stock
    starts_part: float  #: 1 if the block starts a part
    material: float  #: index among the materials of the task
    seconds: float  #: nominal time, for the due dates, s
    part: float  #: index of the part that decides its random numbers; negative to use the index of the block


read_drawn_kind = column_reader(DrawnKind)
SECONDS, PART = DrawnKind._fields.index("seconds"), DrawnKind._fields.index("part")


class Sigmas(NamedTuple):
    """Fields of `tasks.Spread`, and further numbers from which rows are drawn.

    `gauge` and `diamond_flat` are mm, `lot_probability` is a probability. `stock`, `measurement`, `lot_growth`,
    `lot_pressure`, `wheel_growth`, `wheel_roughness`, `part_roughness`, `fracture_force`, `g_ratio`, `convection` and
    `coolant_ageing` have no unit.
    """

    stock: float
    gauge: float
    measurement: float
    lot_probability: float
    lot_growth: float
    lot_pressure: float
    wheel_growth: float
    wheel_roughness: float
    part_roughness: float
    fracture_force: float
    g_ratio: float
    convection: float
    coolant_ageing: float
    diamond_flat: float
    ageing: float  #: log convection lost with every part, no unit
    due_blocks: float  #: number of blocks up to a due date; 0 in a task without due dates
    least_slack: float  #: smallest ratio of the time to a due date to the nominal time
    most_slack: float  #: largest ratio of the time to a due date to the nominal time
    whole_micrometres: float  #: 1 if stocks are on the resolution of the control
    new_wheels: float  #: 1 if wheels after the first one have factors of their own


read_sigmas, read_wheel = column_reader(Sigmas), column_reader(OtherWheel)
SAME = OtherWheel()


@inlined
def origin_of(
    u_0: float, u_1: float, blocks: int, given: Fixed, split: Draws, sigmas: Sigmas, materials: Any, wheels: Any
) -> Origin:
    """Return the origin of an episode of `blocks` blocks from two uniform numbers, its context and its split.

    A foreign split draws one of the `materials`, shape (any,), and one of the `wheels`, shape (any, fields of
    `OtherWheel`).
    """
    key_0, key_1 = key_of(u_0, u_1)
    kA_word, ra_word, fc_word, Gref_word = words_of(key_0, key_1, EPISODE, 0)
    hf_word, ageing_word, _, _ = words_of(key_0, key_1, EPISODE, 1)
    spare_kA_word, spare_ra_word, material_word, wheel_word = words_of(key_0, key_1, EPISODE, 2)
    material, other = given.material, SAME
    if split.foreign > 0.0:
        if materials.size > 0:
            material = unless(material, materials[int(uniform(material_word) * materials.size)])
        if wheels.shape[0] > 0:
            other = read_wheel(wheels, int(uniform(wheel_word) * wheels.shape[0]))
    growth, ranges = split.reach * sigmas.wheel_growth, split.bits
    spare_kA_word = spare_kA_word if sigmas.new_wheels > 0.0 else kA_word
    spare_ra_word = spare_ra_word if sigmas.new_wheels > 0.0 else ra_word
    ageing = 1.0 + sigmas.coolant_ageing * (2.0 * uniform(ageing_word) - 1.0)
    return Origin(
        key_0=key_0,
        key_1=key_1,
        blocks=float(blocks),
        drawn=0.0,
        ranges=ranges,
        reach=split.reach,
        stocks=split.stock,
        material=material,
        stock=given.stock,
        kA=given.kA,
        pm=given.pm,
        ra_scale=given.ra_scale,
        slack=given.slack,
        noise=unless(given.noise, split.noise),
        wheel_kA=unless(given.wheel_kA, other.kA * factor(growth, kA_word, ranges)),
        spare_kA=unless(given.wheel_kA, other.kA * factor(growth, spare_kA_word, ranges)),
        wheel_ra=other.RaRef * factor(sigmas.wheel_roughness, ra_word, ranges),
        spare_ra=other.RaRef * factor(sigmas.wheel_roughness, spare_ra_word, ranges),
        hf=unless(given.hf, factor(sigmas.convection, hf_word, ranges)),
        ageing=sigmas.ageing * unless(given.coolant_ageing, ageing),
        fc=unless(given.fc, other.fc * factor(sigmas.fracture_force, fc_word, ranges)),
        Gref=unless(given.Gref, other.Gref * factor(sigmas.g_ratio, Gref_word, ranges)),
    )


@inlined
def work_before_date(schedule: Any, kinds: Any, i: int, k: int, period: int) -> float:
    """Return the nominal time of block k of episode i and of the later blocks up to the next due date, s."""
    work = 0.0
    for later in range(k - k % period + period - 1, k - 1, -1):
        work += kinds[schedule[i, later] >> 1, SECONDS]
    return work


@inlined
def draw_row(tape: Any, of: Block, drawn: Drawn, source: Any, schedule: Any, kinds: Any, sigmas: Sigmas) -> None:
    """Write the tape row of a block from its random numbers and the row before; arguments as for `draw_rows`."""
    i, k = int(of.episode), int(of.number)
    origin, old = read_origin(source, i), read_carried(source, i)
    number, begins = schedule[i, k] >> 1, schedule[i, k] & 1 > 0
    kind, period, noise = read_drawn_kind(kinds, number), int(sigmas.due_blocks), origin.noise
    starts = kind.starts_part > 0.0
    kA, pm, part_ra, parts, due, of_part = old.kA, old.pm, old.part_ra, old.parts, old.due, old.stock
    if k == 0:
        part_ra, parts, due = 1.0, -1.0 if starts else 0.0, 0.0
    stock = of_part if kind.part >= 0.0 else kind.stock  # in a program, blocks have the stock of their part
    new_lot, gauged = begins, stock
    if starts or begins:
        # if the context fixes both factors of a lot, no lot differs from the last one, so none is new
        lots = starts and (np.isnan(origin.kA) or np.isnan(origin.pm))
        new_lot = begins or (lots and uniform(drawn.lot) < sigmas.lot_probability)
        if new_lot:
            kA = unless(origin.kA, factor(origin.reach * sigmas.lot_growth, drawn.kA, origin.ranges))
            pm = unless(origin.pm, factor(origin.reach * sigmas.lot_pressure, drawn.pm, origin.ranges))
        if starts:
            parts += 1.0
            part_ra = log_normal(sigmas.part_roughness, drawn.part_ra) if np.isnan(origin.ra_scale) else 1.0
            relative = origin.stocks * max(kind.least_stock, 1.0 + spread(sigmas.stock, drawn.stock))
            stock = kind.stock * unless(origin.stock, relative)
            stock = np.floor(1000.0 * stock + 0.5) / 1000.0 if sigmas.whole_micrometres > 0.0 else stock
            of_part = stock
            gauged = max(stock + spread(noise * sigmas.gauge, drawn.gauge), 0.3 * kind.stock)
    work, last = 0.0, 0.0
    if period > 0:
        work = work_before_date(schedule, kinds, i, k, period)
        last = 1.0 if k % period == period - 1 else 0.0
        if k % period == 0:
            slack_word, _, _, _ = words_of(origin.key_0, origin.key_1, DATE, k // period)
            slack = sigmas.least_slack + (sigmas.most_slack - sigmas.least_slack) * uniform(slack_word)
            due += unless(origin.slack, slack) * work
    measurement = noise * sigmas.measurement
    shown = 1.0 if new_lot else 0.0  # numba takes no condition among so many keywords
    row = TapeRow(
        kind=float(number),
        stock=stock,
        gauged=gauged,
        new_lot=shown,
        kA=kA * origin.wheel_kA,
        pm=pm,
        hf=origin.hf * exp(-origin.ageing * parts),
        fc=origin.fc,
        Gref=origin.Gref,
        ra_scale=unless(origin.ra_scale, origin.wheel_ra * part_ra),
        part_ra=part_ra,
        mean_noise=spread(measurement, drawn.mean),
        first_noise=spread(measurement, drawn.first),
        peak_noise=spread(measurement, drawn.peak),
        size_noise=spread(measurement, drawn.size),
        roughness_noise=spread(measurement, drawn.roughness),
        wheel_noise=spread(measurement, drawn.wheel),
        material=unless(origin.material, kind.material),
        spare_kA=kA * origin.spare_kA,
        spare_ra_scale=unless(origin.ra_scale, origin.spare_ra * part_ra),
        due=due,
        work=work,
        is_due=last,
    )
    write_row(tape[i], place_of(k, tape.shape[1]), row)
    write_carried(source, i, Carried(kA=kA, pm=pm, part_ra=part_ra, parts=parts, due=due, stock=of_part))


@entry
def draw_waiting(lanes: Any, count: int, tape: Any, source: Any, schedule: Any, kinds: Any, sigmas: Sigmas) -> None:
    """Draw the rows of the blocks in the first `count` lanes; arguments as for `draw_lanes` and `draw_rows`."""
    draw_lanes(lanes)
    for lane in range(count):
        draw_row(tape, read_block(lanes, lane), read_drawn(lanes, lane), source, schedule, kinds, sigmas)


@entry
def draw_rows(tape: Any, block: Any, source: Any, schedule: Any, kinds: Any, spreads: Any, active: Any) -> None:
    """Draw rows for the coming blocks of the episodes in `active`, as many as the tapes have room for.

    Args:
        tape: shape (N, rows, fields of `TapeRow`): the rows of all blocks, or `AHEAD` rows that take turns.
        block: number of the coming block, shape (N,).
        source: shape (N, SOURCE); updated.
        schedule: kind of every block, shape (N, blocks): twice its number, plus 1 if the block begins an order. Without
            orders, only the first block has this 1.
        kinds: shape (kinds, fields of `DrawnKind`).
        spreads: shape (1, fields of `Sigmas`).
        active: indices of the episodes.
    """
    sigmas, lanes, waiting = read_sigmas(spreads, 0), np.zeros(LANES_SIZE), 0
    for i in active:
        first, end = int(source[i, DRAWN]), min(block[i] + tape.shape[1], int(source[i, BLOCKS]))
        for k in range(first, end):
            part = kinds[schedule[i, k] >> 1, PART]
            part = part if part >= 0.0 else float(k)
            of = Block(episode=float(i), key_0=source[i, KEY_0], key_1=source[i, KEY_1], number=float(k), part=part)
            write_block(lanes, waiting, of)
            waiting += 1
            if waiting == LANES:
                draw_waiting(lanes, waiting, tape, source, schedule, kinds, sigmas)
                waiting = 0
        source[i, DRAWN] = max(first, end)
    if waiting > 0:
        draw_waiting(lanes, waiting, tape, source, schedule, kinds, sigmas)
