"""Copies of the true episodes with only the information that a policy may see.

No score rests on information that a policy does not declare by its `sees`.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from grind_env.array_types import Array
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Due
from grind_env.policies import episode_columns as columns
from grind_env.policies.policy import Sees


def reveal(sees: Sees, simulation: Simulation, episodes: Episodes) -> Episodes | None:
    """Return copies of the true episodes with the information that a policy may see.

    Measurement noise is never shown. For `state`, later blocks hold expected values: the current lot lasts, the stock
    is nominal, parts get the usual roughness, due dates after the next one have their mean distance, and a new wheel is
    like the current one.
    """
    if sees == "measurements":
        return None
    shown = simulation.with_full_tapes(episodes)
    shown.hide_noise()
    if sees == "state":
        blocks = shown.tape.shape[1]
        later = np.arange(blocks) > shown.block[:, None]
        coming = shown.coming()
        expected = np.repeat(coming[:, None], blocks, axis=1)
        expected[..., columns.LISTED] = shown.tape[..., columns.LISTED]
        nominal = simulation.kinds[simulation.branches.rows_of(expected), columns.NOMINAL_STOCK]
        expected[..., columns.STOCK] = expected[..., columns.GAUGED] = nominal
        expected[..., columns.NEW_LOT] = 0.0
        # later parts do not have the random roughness factor of the coming part
        expected[..., columns.ROUGHNESS] /= expected[..., columns.PART_ROUGHNESS]
        expected[..., columns.SPARE_ROUGHNESS] /= expected[..., columns.PART_ROUGHNESS]
        expected[..., columns.PART_ROUGHNESS] = 1.0
        shown = replace(shown, tape=np.where(later[..., None], expected, shown.tape))
        first_wheel = shown.memory[:, columns.CHANGES] == 0.0
        for old, new in columns.OF_WHEEL:
            shown.tape[first_wheel, :, new] = shown.tape[first_wheel, :, old]
        if simulation.task.due is not None:
            shown.tape[..., columns.DUE] = expected_dates(
                simulation.task.due, shown.tape, coming[:, columns.DUE], shown.block
            )
    return shown


def expected_dates(dates: Due, tape: Array, due: Array, block: NDArray[np.int64]) -> Array:
    """Return the due date of every block, s, shape (N, blocks); dates after the next one, `due`, have the mean slack.

    Args:
        dates: due dates of the task.
        tape: shape (N, blocks, fields of `TapeRow`).
        due: next date, s, shape (N,).
        block: coming block, shape (N,).
    """
    period = np.arange(tape.shape[1]) // dates.blocks
    # the first block of a period holds the work of the whole period
    work = np.cumsum(tape[:, :: dates.blocks, columns.WORK], axis=1)[:, period]
    done = work[np.arange(len(due)), np.minimum(block, tape.shape[1] - 1)][:, None]
    return np.asarray(due[:, None] + sum(dates.slack) / 2.0 * np.maximum(work - done, 0.0))
