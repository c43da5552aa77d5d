"""Clock times, with or without a date, as seconds."""

import re
from collections.abc import Sequence
from contextlib import suppress
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

DATE = r"\d{1,4}[-./](?:\d{1,2}|[A-Za-z]{3})[-./]\d{1,4}"
#: groups: date, hours, minutes, seconds with a fraction, half of the day (A or P)
CLOCK = re.compile(
    rf"(?:({DATE})[ T,_]+)?(?:(\d{{1,3}}):)?(\d{{1,2}}):(\d{{2}}(?:[.,:]\d+)?)\s*(?:([AaPp])[Mm])?"
    r"(?:\s*(?:Z|UTC|[-+]\d{2}:?\d{2}))?"
)
DATES = ("%Y-%m-%d", "%d-%m-%Y", "%m-%d-%Y", "%d-%m-%y", "%m-%d-%y", "%y-%m-%d", "%d-%b-%Y", "%d-%b-%y", "%Y-%b-%d")
HOUR, DAY = 3600.0, 86_400.0
CROWD = 20  #: rows with the same time, on average, from which on `14:05` is hours and minutes, not minutes and seconds
#: greatest step back of a clock that has not begun anew, s, by its period: rows out of order, end of summer time
BACK = {HOUR: 60.0, DAY: 3700.0}


def clock_seconds(texts: Sequence[str]) -> NDArray[np.float64]:
    """Return clock times in s, counted on beyond midnight; NaN where a text is no time.

    Without a date, a clock that goes back by more than `BACK` has begun anew.
    """
    found = [match.groups() if (match := CLOCK.fullmatch(text)) else None for text in texts]
    times = [each for each in found if each]
    in_hours = any(each[1] for each in times)
    fine = any(len(each[3]) > 2 or int(each[2]) > 23 for each in times) or len(times) < CROWD * len(set(times))
    in_minutes = in_hours or (fine and not any(each[0] or each[4] for each in times))
    period = HOUR if in_minutes and not in_hours else DAY
    seconds = np.full(len(texts), np.nan)
    for row, each in enumerate(found):
        if each is None:
            continue
        _, hours, minutes, rest, half = each
        if not in_minutes:
            hours, minutes, rest = minutes, rest, "0"
        hour = int(hours or 0) if half is None else int(hours or 0) % 12 + 12 * (half in "Pp")
        seconds[row] = HOUR * hour + 60.0 * int(minutes) + float(re.sub("[,:]", ".", rest))
    days = _days([each[0] if each else None for each in found])
    return seconds + (period * _begun_anew(seconds, period) if days is None else DAY * days)


def _days(dates: Sequence[str | None]) -> NDArray[np.float64] | None:
    """Return the days since the first date; None without dates.

    If the order of day and month is ambiguous, the order with the shortest total time is taken.
    """
    distinct = {date: re.sub("[/.]", "-", date) for date in dates if date}
    readings = []
    for form in DATES if distinct else ():
        with suppress(ValueError):
            readings.append({date: datetime.strptime(text, form).toordinal() for date, text in distinct.items()})
    if not readings:
        return None
    shortest = min(readings, key=lambda days: max(days.values()) - min(days.values()))
    first = min(shortest.values())
    return np.array([shortest[date] - first if date else np.nan for date in dates], np.float64)


def _begun_anew(seconds: NDArray[np.float64], period: float) -> NDArray[np.float64]:
    """Return how often a clock has begun anew before each row; rows may run backwards, a few may be out of order."""
    passed, known = np.zeros(seconds.size), np.flatnonzero(np.isfinite(seconds))
    jumps, back = np.diff(seconds[known], prepend=seconds[known[:1]]), BACK[period]
    way = 1.0 if (jumps < 0.0).sum() <= (jumps > 0.0).sum() else -1.0
    anew = np.where(way * jumps < -back, 1.0, np.where(way * jumps > period - back, -1.0, 0.0))
    passed[known] = way * np.cumsum(anew)
    return passed
