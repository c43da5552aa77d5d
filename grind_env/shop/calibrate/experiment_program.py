"""Write a test program with several E and depths, whose log identifies the constants."""

import re
from typing import NamedTuple

import numpy as np

from grind_env.control import CycleStart, Programs, execute, read
from grind_env.control.block_words import Block, read_block
from grind_env.control.events import CyclePlan
from grind_env.control.motion_paths import AXES
from grind_env.control.program_scanner import readable
from grind_env.control.word_rewriting import with_words
from grind_env.machine.grind import grind
from grind_env.machine.job import Job
from grind_env.machine.job.job_entries import with_entries
from grind_env.machine.record import GrindingRecord
from grind_env.message_text import quoted
from grind_env.shop.calibrate.exceptions import CalibrationError

#: test blocks in place of the first block: factors on its E and pick, and whether the wheel is dressed before. The same
#: words meet a worn and a fresh wheel. E and depth vary in opposite directions: varied together, they tell one thing
#: only
CUTS = ((1.0, 1.0, False), (1.5, 0.6, False), (0.6, 1.5, True), (1.0, 1.0, False))
#: shares of the limits that the plan keeps with a wheel that ploughs `HARDER` times as hard. If the program itself then
#: reaches higher shares, the plan may reach them, too
SAFE_POWER, SAFE_RISE = 0.6, 0.8
LESS_GOOD = 0.02  #: greatest decrease of the probability of a good part, compared with the program
HARDER = 1.5  #: factor on the ploughing pressure by which the catalogue may be wrong
SPANS = (1.0, 0.75, 0.5, 0.3)  #: exponents of all factors, from the widest on; the first safe one is taken
MM, INCH = 3, 4  #: decimals that the control reads in mm and in inches


class Plan(NamedTuple):
    """Test program whose log determines constants."""

    text: str  #: text of the program
    blocks: tuple[tuple[float, float], ...]  #: E, mm/min, and pick, mm, of the test blocks
    power: float  #: highest expected share of the power limit
    rise: float  #: highest expected share of the limit of the temperature rise

    def __str__(self) -> str:
        cuts = ", ".join(f"E{feed:.0f} with picks of {pick:.3f} mm" for feed, pick in self.blocks)
        return (
            f"It grinds one part, at {cuts}, with one dress between, and goes on as the program does; even if "
            f"the wheel ploughs {HARDER:g} times as hard as the catalogue says, the power stays below "
            f"{100.0 * self.power:.0f} % and the temperature rise below {100.0 * self.rise:.0f} % of its limit. Log it "
            "two or three times, and give what was gauged."
        )


def plan_of(programs: Programs, job: Job) -> Plan:
    """Return the program with test blocks in place of its first block that plunges."""
    first = next((event.plan for event in execute(programs, job.control) if isinstance(event, CycleStart)), None)
    block = None if first is None else _block(programs, first)
    if first is None or block is None or not first.plunges:
        raise CalibrationError(
            f"{programs.name}: its first cycle is no G82 or G83 with plain numbers, so that no plan can be made of it; "
            "vary E and the feed of its infeed by hand, from part to part of one log"
        )
    hard = with_entries(job, {"material": {"ploughing_pressure": HARDER * job.part.material.ploughing_pressure}})
    own = grind(programs, hard)
    allowed = [max(each) for each in zip(_shares(own, job), (SAFE_POWER, SAFE_RISE), strict=True)]
    for span in SPANS:
        text, blocks = _text(programs, block, first, span, job.setup.machine.maximum_table_speed)
        record = grind(read(text, programs.name), hard)
        power, rise = _shares(record, job)
        good, before = (float(each.parts["survival"].min()) for each in (record, own))
        as_good = len(record.warnings) <= len(own.warnings) and good >= before - LESS_GOOD
        if power <= allowed[0] and rise <= allowed[1] and as_good:
            return Plan(text, blocks, power, rise)
    raise CalibrationError(
        f"{programs.name}: with other words it would come to {100.0 * power:.0f} % of the power and {100.0 * rise:.0f} "
        f"% of the temperature rise that are allowed, and to {len(record.warnings)} warnings; log the program as it is"
    )


def _shares(record: GrindingRecord, job: Job) -> tuple[float, float]:
    power, rise = (float(record.parts[name].max()) for name in ("peak_power", "rise"))
    return power / job.limits.power, rise / job.limits.rise


def _block(programs: Programs, plan: CyclePlan) -> Block | None:
    """Return the block of a cycle; None if its numbers are not written in it."""
    sources = [each for each in programs.main.blocks if each.line == plan.line]
    found = read_block(sources[0]) if len(sources) == 1 else None
    return found if found is not None and found.is_plain else None


def _text(
    programs: Programs, block: Block, plan: CyclePlan, span: float, fastest: float
) -> tuple[str, tuple[tuple[float, float], ...]]:
    """Return the text of the plan, and E and pick of its test blocks."""
    assert plan.plunge_axis is not None
    depth, cross = AXES[plan.plunge_axis], plan.cross_axis
    numbers = {word.letter: float(str(word)[1:]) for word in block.words}
    target, pick, feed = (numbers.get(letter) for letter in (depth, "J", "E"))
    if target is None or pick is None or feed is None:
        raise CalibrationError(f"{quoted(block.source.text)}: it needs {depth}, J and E of its own for a plan")
    unit = abs(pick) / plan.primary_pick  # units of the program per mm
    if abs(target - unit * plan.depth_target) > abs(pick):
        raise CalibrationError(
            f"{quoted(block.source.text)}: {depth}{target:g} with picks J{pick:g} is not where the cycle ends; a plan "
            "needs a cycle in G19, absolute and without a work offset: vary E and J by hand, from part to part of a log"
        )
    digits, begin = MM if unit > 0.5 else INCH, unit * plan.plunge_start
    cuts = [(faster**span, deeper**span, dresses) for faster, deeper, dresses in CUTS]
    share = np.cumsum([deeper for _, deeper, _ in cuts]) / sum(deeper for _, deeper, _ in cuts)
    lines, words = list[str](), list[tuple[float, float]]()
    for number, ((faster, deeper, dresses), done) in enumerate(zip(cuts, share.tolist(), strict=True)):
        to = begin + done * (target - begin)
        E, J = min(faster * plan.feed, fastest), round(deeper * pick, digits)
        values = {depth: f"{to:.{digits}f}", "J": f"{J:.{digits}f}", "E": f"{E / plan.feed * feed:.0f}."}
        if plan.program is not None:
            values["D"] = str(int(dresses))
        if number and cross is not None:
            lines.append(f"G01 {AXES[cross]}{unit * plan.cross_start:.{digits}f} F{unit * plan.pick_feed:.0f}.")
        lines.append(re.sub(r"^\s*N\d+\s*", "", with_words(block, values).source.text))
        words.append((E, abs(J) / unit))
    with programs.main.blocks.text.open() as handle:
        whole = readable(handle.read().decode("utf-8-sig", "surrogateescape")).splitlines()
    at = block.source.line - 1
    remark = "(A LOG OF THIS TELLS THE CONSTANTS OF WHEEL AND MATERIAL)"
    return "\n".join([*whole[:at], remark, *lines, *whole[at + 1 :]]) + "\n", tuple(words)
