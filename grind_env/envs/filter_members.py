"""A simulation whose episodes are the members of a belief filter."""

from collections.abc import Sequence

import numpy as np

from grind_env.array_types import Numbers, Table
from grind_env.belief.filter_quantities import FACTORS, Hidden, Judged
from grind_env.belief.wheel_belief import BeliefError
from grind_env.envs.block_kind_rows import KindRow
from grind_env.envs.cost import Outcome
from grind_env.envs.episode_state import Episodes
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.simulation import Simulation, without_wheel_changes
from grind_env.machine.loops.block_change import entries_of

JUDGED = [KindRow._fields.index(name) for name in Judged._fields]
MADE = [Outcome._fields.index(name) for name in ("size_error", "roughness_ratio")]
FACTOR_COLUMNS = [TapeRow._fields.index(name) for name in FACTORS]


class MemberModel:
    """Simulation whose episodes are the members of a filter: single blocks, each with its own factors.

    Args:
        simulation: the simulation that is estimated; its entries define the observations.

    Raises:
        BeliefError: the steps of the simulation are not compiled.
    """

    def __init__(self, simulation: Simulation) -> None:
        if not simulation.compiled:
            raise BeliefError(
                f"{simulation.task.name} is not followed by a belief, which grinds compiled blocks: use HistoryStack"
            )
        # the diameter is observed: a member below the minimum diameter must not change its wheel
        self.simulation, self.branches = without_wheel_changes(simulation), simulation.branches
        task = simulation.task
        spread = task.spread
        self.base, self.ageing, self.noise = self.branches.base, task.setup.coolant_ageing, spread.measurement
        self.sigmas = Hidden(
            wheel_growth=spread.wheel_growth,
            fracture_force=spread.fracture_force,
            g_ratio=spread.g_ratio,
            convection=spread.convection,
            coolant_ageing=spread.coolant_ageing,
            lot_growth=spread.lot_growth,
            lot_pressure=spread.lot_pressure,
        )
        self.dress = self.branches.usual_dress

    def base_rows(self, rows: Numbers) -> Numbers:
        return np.minimum(rows, len(self.base) - 1)

    def judged(self, rows: Numbers) -> Table:
        return self.simulation.kinds[rows][:, JUDGED]

    def empty_episodes(self, n: int) -> Episodes:
        return self.simulation.empty_episodes(n).on(np.zeros((n, 1, len(TapeRow._fields))))

    def write_factors(self, members: Episodes, index: Numbers, factors: Table) -> None:
        members.tape[index[:, None], 0, FACTOR_COLUMNS] = factors

    def rest(self, members: Episodes, index: Numbers, rows: Numbers) -> None:
        pass_time, p = entries_of(self.simulation.process).pass_time, self.base[self.base_rows(rows)]
        for k, i in enumerate(index):
            pass_time(members.wheels[i : i + 1], p[k : k + 1], 0, self.branches.change_seconds, False)

    def grind(self, members: Episodes, choice: Sequence[Table], index: Numbers) -> tuple[Table, Table]:
        outcomes, tallies = self.simulation.step(members, *choice, active=index)
        return tallies, outcomes[:, MADE]
