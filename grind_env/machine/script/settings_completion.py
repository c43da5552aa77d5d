"""Chosen settings of the blocks of a script, checked and completed from the blocks."""

import math
from collections.abc import Sequence

import numpy as np

from grind_env.array_types import Array
from grind_env.errors import GrindError
from grind_env.machine.dress.dress_run import DEEPEST_INFEED
from grind_env.machine.dress.dress_time import dress_seconds
from grind_env.machine.script.block_settings import DRESS_DEPTH, DRESS_FEED, DRESS_PASSES, DRESS_SECONDS, J, L
from grind_env.machine.script.script import Script
from grind_env.machine.script.script_tables import CYCLE, NO_CYCLE, ScriptTables

ABOVE_ZERO = math.nextafter(0.0, 1.0)


class SettingsError(GrindError):
    """Settings with which a block cannot be run."""


def complete_settings(script: Script, tables: ScriptTables, block: Array, settings: Array) -> Array:
    """Return the settings that blocks use, shape (N, fields of `BlockSettings`): their own if they lack the word.

    The time of a dress is computed. Raises a `SettingsError` where J or L are outside the ranges of the script, or no
    dress program has such settings.
    """
    own, result = tables.own_settings[block], settings.copy()
    plunges, dresses = tables.blocks[block, CYCLE] != NO_CYCLE, own[:, DRESS_PASSES] > 0.0
    result[~plunges, J : L + 1] = own[~plunges, J : L + 1]
    result[~dresses, DRESS_PASSES:] = own[~dresses, DRESS_PASSES:]
    _refuse_outside(script, block, own, result)
    for number in np.unique(block[dresses]).tolist():
        run, rows = script.blocks[number].dress, block == number
        assert run is not None
        dress = result[rows, DRESS_PASSES:DRESS_SECONDS].T
        result[rows, DRESS_SECONDS] = dress_seconds(run, script.job.control, *dress)
    return result


def _refuse_outside(script: Script, block: Array, own: Array, settings: Array) -> None:
    ranges, fastest = script.ranges, script.job.control.maximum_feed / 60.0
    bounds: tuple[tuple[int, str, float, float, bool], ...] = (
        (J, "J of {:g} mm", *_ends(ranges.J, ABOVE_ZERO), False),
        (L, "L of {:g}", *_ends(ranges.L, 0.0), True),
        (DRESS_PASSES, "dress of {:g} passes", 1.0, math.inf, True),
        (DRESS_FEED, "dress feed of {:g} mm/s", ABOVE_ZERO, fastest, False),
        (DRESS_DEPTH, "dress infeed of {:g} mm", ABOVE_ZERO, DEEPEST_INFEED, False),
    )
    for column, said, low, high, whole in bounds:
        value = settings[:, column]
        right = (low <= value) & (value <= high) & ((np.floor(value) == value) | (not whole))
        wrong = np.flatnonzero(~(right | (value == own[:, column])))
        if wrong.size > 0:
            i = wrong[0]
            place = f"{script.programs.name}:{script.blocks[block[i]].plan.line}"
            legal = "only that of the block is" if low > high else f"{low:g} to {high:g} are"
            number = "whole numbers " if whole else ""
            raise SettingsError(f"{place}: a {said.format(value[i])} was chosen, but {number}{legal} legal here")


def _ends(values: Sequence[float], least: float) -> tuple[float, float]:
    """Return both ends of the range of a word, within legal values; (inf, -inf) for a word without a range."""
    return (max(min(values), least), max(values)) if values else (math.inf, -math.inf)
