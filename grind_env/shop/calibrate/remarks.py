"""What is to be known of a calibration beside its numbers, as sentences."""

from pathlib import Path

import numpy as np

from grind_env.errors import listed
from grind_env.process.user_catalogue import OVERRIDES
from grind_env.shop.calibrate.alignment import SAME_FEED, Alignment
from grind_env.shop.calibrate.fit import Fit
from grind_env.shop.calibrate.logs import Log
from grind_env.shop.calibrate.observe import Observations
from grind_env.shop.calibrate.pattern import Pattern
from grind_env.toml import read_toml

NAMED = 3
"""Runs that are named, of those that were left out."""


def log_remarks(log: Log, found: Alignment, seen: Observations, pattern: Pattern) -> list[str]:
    """How the log lies beside the program."""
    executions = f"{found.executions} times" if found.executions > 1 else "once"
    remarks = [f"the program is in the log {executions}; median correlation of its runs of strokes {found.quality:.2f}"]
    if log.lag:
        remarks.append(f"the meter lags by about {log.lag:.2g} s, which was taken out")
    if not log.sure_of_time:
        remarks.append(f"the time has no unit; as the program says it is in {'s' if found.time_unit == 1.0 else 'ms'}")
    changed = [f"part {k}: {100.0 * each:.0f} %" for k, each in enumerate(found.overrides(pattern), 1) if each != 1.0]
    if changed:
        remarks.append(f"the feed was overridden, {listed(changed)}")
    usual = found.usual_override(pattern)
    if abs(np.log(usual)) > np.log(SAME_FEED):
        remarks.append(
            f"in all parts the table went at {100.0 * usual:.0f} % of its pace; what is found holds for the feeds as "
            "they are programmed"
        )
    left_out = np.argwhere(np.isfinite(found.correlation) & ~found.sure)
    if left_out.size:
        firsts = pattern.firsts[left_out[:, 1]]
        parts = left_out[:, 0] * pattern.parts + pattern.part[firsts] + 1
        names = [
            f"part {part} from line {line} on"
            for part, line in zip(parts.tolist(), pattern.line[firsts].tolist(), strict=True)
        ]
        remarks.append(
            f"runs of strokes that are not in the log as programmed were left out: {listed(names, NAMED)}; a "
            "feed that was overridden in the middle is such a case"
        )
    if pattern.crosses.any():
        remarks.append(
            "of cycles that cross means of whole blocks are fitted, for what one stroke of them cuts a log does not "
            "tell"
        )
    if not seen.by_stroke:
        remarks.append(
            "the log has fewer than five samples a stroke, so that means of whole runs of strokes are fitted"
        )
    return remarks


def overridden(job: Path, fitted: Fit, *, idle: bool) -> list[str]:
    """Constants that the job itself sets, so that those of a catalogue file have no effect."""
    setup = read_toml(job).get("setup", {})
    fixed = {f"{table.removesuffix('_overrides')}.{key}" for table in OVERRIDES for key in setup.get(table, {})}
    told = [each.name for each, tells in zip(fitted.parameters, fitted.told.tolist(), strict=True) if tells]
    told += ["machine.idle_power", "machine.power_limit"] if idle else []
    names = [name for name in told if name in fixed]
    if not names:
        return []
    return [f"the job sets {', '.join(names)} itself; take it out there, or what is found has no effect"]
