"""What a setting of `grind/Wen-v0` comes to."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from grind_env.process.wen import CASES, Setting, Verdict, judge_settings

Array = NDArray[Any]

CASE_ROWS = np.array(list(CASES.values()))
OBJECTIVE, VIOLATION = Verdict._fields.index("objective"), Verdict._fields.index("violation")


def judged(settings: Array, cases: Array) -> Array:
    """Verdicts, shape (N, fields of `Verdict`), of settings for cases given by number, shape (N,)."""
    verdicts = np.empty((len(settings), len(Verdict._fields)))
    judge_settings(settings, CASE_ROWS[cases], verdicts)
    return verdicts


def named(setting: Array, verdict: Array) -> tuple[Setting, Verdict]:
    """A setting and its verdict, rows of such tables, by name."""
    return Setting(*setting.tolist()), Verdict(*verdict.tolist())
