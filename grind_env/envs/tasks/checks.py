"""What the tables of a task must keep together: whole parts, a wheel that suits them, blocks that a program can say."""

import math

from grind_env.control.rules import motion_time, picks_to
from grind_env.envs.machines import plants_of
from grind_env.envs.tasks.numbers import TaskNumbers
from grind_env.envs.tasks.tables import Kind, TaskError
from grind_env.errors import GrindError, quoted, shortened
from grind_env.machine.dress.wheel_body import half_chord
from grind_env.process.corrected import exponents_of
from grind_env.process.state import StrokeParameters
from grind_env.process.tables import refuse_unknown, wrong
from grind_env.process.user_catalogue import entry_of

PICK_FEED, CROSS_FEED = 60.0, 1500.0
"""mm/min of the picks of a G82, and of all picks of a G83."""

MOST_STROKES, MOST_ACROSS = 100_000, 200
"""Strokes of a block, and of a traverse; with more of them a pick or an infeed is a slip."""


def check_whole(task: TaskNumbers) -> None:
    """Check what depends on more than one table, or on the catalogue."""
    if not task.kinds:
        raise TaskError("kind is missing: give at least one block, headed [[kind]]", "kind")
    names = [kind.name for kind in task.kinds]
    for name in names:
        if names.count(name) > 1:
            raise TaskError(f"kind.name is {quoted(name)} twice: give every kind a name of its own", "kind.name", name)
    if bool(task.sequence) == (task.orders is not None):
        raise TaskError("the blocks need either sequence or [orders]: give exactly one of the two", "sequence")
    if task.orders is not None:
        _refuse_pieces(task, "[orders]")
    if task.due is not None and task.blocks % task.due.blocks:
        message = f"due.blocks is {task.due.blocks}, but must divide the {task.blocks} blocks evenly"
        raise TaskError(message, "due.blocks", task.due.blocks)
    task.numbers(task.nominal_sequence, "sequence")
    refuse_unknown(task.factors, StrokeParameters._fields, TaskError, "factors.")
    for kind in task.kinds:
        material = entry_of(task.catalogue, "kind.material", kind.material, {}, TaskError)
        if any(exponents_of(material)):
            raise TaskError(
                f"kind.material: {material} has exponents of the power, by which only jobs grind: use it in a job "
                "(grind/Job-v0), or set them to 0",
                "kind.material",
                kind.material,
            )
        _check_wheel_covers(task, kind)
    if task.infeed > 0.0:
        _refuse_pieces(task, "infeed")
        _check_infeeds(task)
    if task.cross_pick > 0.0:
        _check_crossing(task)
    for kind in task.kinds:
        _check_strokes(task, kind)
        if task.cycle == "G82":
            _check_clear(task, kind)
    _check_start(task)


def check_plant(name: str) -> None:
    """Check the machine that a task names."""
    try:
        plants_of(None, name)
    except GrindError as error:
        raise TaskError(f"plant: {error}", "plant", name) from None


def _refuse_pieces(task: TaskNumbers, place: str) -> None:
    """Refuse kinds that are no whole parts."""
    for kind in task.kinds:
        if not (kind.starts_part and kind.ends_part):
            raise TaskError(f"{place}: a {kind.name} is no whole part: let it start and end one", "kind.ends_part")


def _check_wheel_covers(task: TaskNumbers, kind: Kind) -> None:
    wheel = task.wheel.width
    sizes = f"a {kind.name} of {shortened(task.name)} is {kind.width:g} mm wide, the wheel {wheel:g} mm"
    if task.cycle != "G83" and kind.width > wheel:
        message = f"{sizes}: a {task.cycle} grinds only one strip of it; give a cross_pick for a G83, or a wider wheel"
        raise TaskError(message, "kind.width", kind.width)
    if task.cycle == "G83" and kind.width <= wheel:
        message = f"{sizes}: a G83 has no strip to cross to; leave out cross_pick for a G82"
        raise TaskError(message, "kind.width", kind.width)


def _check_strokes(task: TaskNumbers, kind: Kind) -> None:
    """Refuse more strokes than anyone waits for, and picks that are not over when the table is back."""
    fastest = task.stroke_seconds(kind, task.action.speed_ends[1])
    strokes = 60.0 * kind.stock / task.infeed / fastest if task.infeed > 0.0 else task.strokes(kind, kind.stock)
    if strokes > MOST_STROKES:
        key, value = ("infeed", task.infeed) if task.infeed > 0.0 else ("kind.pick", kind.pick)
        raise TaskError(
            f"{key} is {value:g}, so that a {kind.name} takes {strokes:.0f} strokes, but {MOST_STROKES} are the "
            "most: take more, or less stock",
            key,
            value,
        )
    picks = {} if task.infeed > 0.0 else {"kind.pick": kind.pick, "cross_pick": task.cross_pick}
    feed = CROSS_FEED if task.cycle == "G83" else PICK_FEED
    for key, pick in picks.items():
        if motion_time(pick, feed / 60.0, task.machine.acceleration) > 0.5 * fastest:
            raise TaskError(
                f"{key} is {pick:g} mm, which at {feed:g} mm/min takes longer than half a stroke of a {kind.name} "
                f"at {task.action.speed_ends[1]:g} m/min, {0.5 * fastest:.3g} s: take less",
                key,
                pick,
            )


def _check_clear(task: TaskNumbers, kind: Kind) -> None:
    """Refuse an overrun so short that the wheel would grind the part before the G82, which begins at the first pick."""
    diameter, overrun = task.wheel.diameter, task.setup.overrun
    # the first pick goes no deeper than the stock, of which a part with a spread may have any
    first = kind.pick if task.spread.stock > 0.0 else min(kind.pick, kind.stock)
    least = math.ceil(1000.0 * half_chord(0.5 * diameter, first)) / 1000.0
    if overrun < least:
        way = (
            f"the {diameter:g} mm wheel grinds the part as it comes down beside it, {first:g} mm deep in its first pick"
        )
        legal = f"at least {least:.3f} mm, or {way}"
        raise wrong("setup.overrun", overrun, legal, TaskError)


def _check_infeeds(task: TaskNumbers) -> None:
    """Refuse more dresses than there are micrometres to part the infeed between them."""
    for kind in task.kinds:
        least = kind.stock * (kind.least_stock if task.spread.stock > 0.0 else 1.0)
        if least < 0.001 * (task.action.executions + 1):
            raise TaskError(
                f"action.executions is {task.action.executions}, but a {kind.name} may have only {least:g} mm "
                "of stock, which a G81 parts in steps of 0.001 mm between them: allow fewer dresses, or more stock",
                "action.executions",
                task.action.executions,
            )


def _check_crossing(task: TaskNumbers) -> None:
    if task.infeed > 0.0:
        raise TaskError("the task has both infeed (G81) and cross_pick (G83): give one of the two", "cross_pick")
    if len(task.kinds) > 1:
        raise TaskError(
            f"{shortened(task.name)} has several kinds of blocks; a G83 task has one, which is a whole part", "kind"
        )
    across = picks_to(task.kinds[0].width - task.wheel.width, task.cross_pick)
    if task.cross_pick > task.wheel.width or across > MOST_ACROSS:
        least = (task.kinds[0].width - task.wheel.width) / MOST_ACROSS
        legal = f"from {least:.3g} mm ({MOST_ACROSS} strokes) to the width of the wheel, {task.wheel.width:g} mm"
        raise wrong("cross_pick", task.cross_pick, legal, TaskError)


def _check_start(task: TaskNumbers) -> None:
    area, left = task.start.wear_flat_area, task.start.executions_left
    if area is not None and area >= task.wheel.wear_flat_limit:
        raise wrong("start.wear_flat_area", area, f"below {task.wheel.wear_flat_limit:g} for {task.wheel}", TaskError)
    most = (task.wheel.diameter - task.wheel.minimum_diameter) / task.execution_depth
    if left is not None and left[1] > most:
        raise wrong(
            "start.executions_left", left, f"at most {math.floor(most)}, which a new {task.wheel} has", TaskError
        )
