"""Start and stop of the table: by grinding cycles, G80, and the end of the program."""

import functools
from collections.abc import Iterator
from dataclasses import replace

from grind_env.control.block_decoding import Command
from grind_env.control.control_settings import Control
from grind_env.control.cycle_execution import grind, grind_whole_cycle, least_strokes
from grind_env.control.cycle_planning import ModalWords, Situation, plan_cycle, redirect
from grind_env.control.events import CycleEnd, CyclePlan, CycleStart, Event, Position, TableStop
from grind_env.control.execution_limits import Rounds
from grind_env.control.interruptions import Interruptions
from grind_env.control.modes import PLANES
from grind_env.control.motion_paths import AXES, INTEGRANDS, displaced, moved_by
from grind_env.control.move_execution import Mover
from grind_env.control.reciprocation import Reciprocation


class Reciprocator:
    """Execution of cycle blocks, and of the reciprocation that continues after them."""

    def __init__(self, mover: Mover, interruptions: Interruptions, control: Control) -> None:
        self.timeline, self.mover, self.interruptions, self.control = mover.timeline, mover, interruptions, control
        self.memory = ModalWords()  # words that later cycle blocks may omit, in coordinates of the program

    def redirect(self, command: Command) -> None:
        table = self.timeline.reciprocation
        if command.reciprocation_feed is not None:
            self.memory = replace(self.memory, feed=command.reciprocation_feed)
        if table is not None:
            named = [letter for letter in (AXES[table.axis], INTEGRANDS[table.axis]) if letter in command.words]
            if command.in_machine and named:
                message = (
                    f"{command.words[named[0]]} is for {AXES[table.axis]}, which reciprocates; program G80 before G53"
                )
                raise command.error("axis-conflict", message, named[0])
            origin = self.mover.work.origin(command.modes.work_system)[table.axis]
            self.memory = redirect(command, self.memory, table, origin, self.control.maximum_feed)

    def cycle(self, command: Command) -> Iterator[Event]:
        timeline, table = self.timeline, self.timeline.reciprocation
        plan, memory = self.planned(command)
        while table is not None and not table.at_secondary:
            yield from self.interruptions.next_reversal()
        yield from self._end_reciprocation_cycle()
        self.memory = memory
        place = command.block.place
        timeline.budget.foresee(least_strokes(plan, self.control.coverage_pass), place)
        if table is None:
            start = timeline.position[plan.axis]
            table = Reciprocation(plan, place, plan.primary, plan.secondary, plan.feed, start, timeline.time)
            timeline.reciprocation = table
        else:
            table.take_over(plan, place)
        timeline.infeed_shift = 0.0
        timeline.led_by_cycles |= {plan.axis} if plan.cross_axis is None else {plan.axis, plan.cross_axis}
        modes, origins = self.mover.modes, self.mover.work.origins
        yield CycleStart(timeline.time, plan, self.interruptions.variables.values, modes, origins)
        if plan.pre_dress and plan.program is not None:
            yield from self.interruptions.dress(plan.program, "pre")
        if not plan.plunges:
            return
        table.auto_dresses = Rounds(timeline.budget, place, plan.dresses)
        table.in_cycle = True
        alone = self.control.whole_cycles and self.interruptions.nothing_comes_between(plan)
        whole = grind_whole_cycle(plan, timeline) if alone else None
        if whole is None:
            yield from grind(plan, self.interruptions)
        else:
            yield whole
        timeline.settle()
        table.in_cycle = False
        yield CycleEnd(timeline.time, plan, table.count, table.dresses)

    def planned(self, command: Command) -> tuple[CyclePlan, ModalWords]:
        table = self.timeline.reciprocation
        self.mover.refuse_displaced(command)
        origin = self.mover.work.origin(command.modes.work_system)
        situation = Situation(
            moved_by(self.timeline.position, origin, -1.0),
            None if table is None else table.axis,
            0.0 if table is None else displaced(table.secondary, -origin[table.axis]),
            self.control.maximum_feed,
        )
        plan, memory = _planned(command, self.memory, situation, origin)
        self._refuse_compensation(command, plan)
        return plan, memory

    def cancel(self, command: Command) -> Iterator[Event]:
        command.allow_only("", "a G80 block")
        yield from self.stop()

    def run_on(self) -> Iterator[Event]:
        """Make the strokes of a G81 that still runs at the end of the text (ruling 11)."""
        table = self.timeline.reciprocation
        while table is not None and not table.plan.plunges and table.count < self.control.strokes:
            yield from self.interruptions.next_reversal()

    def stop(self) -> Iterator[Event]:
        table = self.timeline.reciprocation
        if table is not None and not table.at_reversal:
            yield from self.interruptions.next_reversal()
        yield from self._end_reciprocation_cycle()
        self.timeline.reciprocation = None
        if table is not None and self.control.announce_cycles:
            yield TableStop(self.timeline.time, table.plan)

    def _end_reciprocation_cycle(self) -> Iterator[Event]:
        table = self.timeline.reciprocation
        if table is not None and not table.plan.plunges:
            yield CycleEnd(self.timeline.time, table.plan, table.count, table.dresses)

    def _refuse_compensation(self, command: Command, plan: CyclePlan) -> None:
        side = command.modes.compensation
        if side == "G40":
            return
        for axis in (plan.axis, plan.plunge_axis, plan.cross_axis):
            if axis is not None and axis in PLANES[command.modes.plane]:
                raise command.error(
                    "compensation", f"{command.action} moves {AXES[axis]} of the plane of {side}; program G40 before"
                )


@functools.lru_cache(maxsize=256)
def _planned(
    command: Command, memory: ModalWords, situation: Situation, origin: Position
) -> tuple[CyclePlan, ModalWords]:
    plan, memory = plan_cycle(command, memory, situation)
    return _on_machine(plan, origin), memory


def _on_machine(plan: CyclePlan, origin: Position) -> CyclePlan:
    def shifted(coordinate: float, axis: int | None) -> float:
        return coordinate if axis is None else displaced(coordinate, origin[axis])

    return replace(
        plan,
        primary=shifted(plan.primary, plan.axis),
        secondary=shifted(plan.secondary, plan.axis),
        plunge_start=shifted(plan.plunge_start, plan.plunge_axis),
        depth_target=shifted(plan.depth_target, plan.plunge_axis),
        cross_start=shifted(plan.cross_start, plan.cross_axis),
        cross_end=shifted(plan.cross_end, plan.cross_axis),
    )
