"""What a setting of `grind/Wen-v0` comes to."""

import numpy as np

from grind_env.arrays import Array
from grind_env.envs.wen.model import CASES, Setting, WenVerdict, judge_settings

CASE_ROWS = np.array(list(CASES.values()))
OBJECTIVE, VIOLATION = WenVerdict._fields.index("objective"), WenVerdict._fields.index("violation")


def judged(settings: Array, cases: Array) -> Array:
    """Verdicts, shape (N, fields of `WenVerdict`), of settings for cases given by number, shape (N,)."""
    verdicts = np.empty((len(settings), len(WenVerdict._fields)))
    judge_settings(settings, CASE_ROWS[cases], verdicts)
    return verdicts


def named(setting: Array, verdict: Array) -> tuple[Setting, WenVerdict]:
    """A setting and its verdict, rows of such tables, by name."""
    return Setting(*setting.tolist()), WenVerdict(*verdict.tolist())
