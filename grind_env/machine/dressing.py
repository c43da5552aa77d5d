"""The dress programs of a run: what each does by itself, and that it does the same where a cycle calls it."""

from collections.abc import Iterator

from grind_env.control import Control, DressEnd, DressStart, Motion, Position, Programs
from grind_env.machine.dress_program import (
    DressPlan,
    is_dress_program,
    measure_dress,
    plain_calls,
    plan_dress,
    require_same,
)
from grind_env.machine.job import Job


class DressPrograms:
    """What is known of the dress programs of a run.

    Attributes:
        plans: what those met so far do, by O number.
        under_way: the start of the execution under way; None while there is none.
    """

    def __init__(self, programs: Programs, job: Job, control: Control) -> None:
        self.programs, self.job, self.control = programs, job, control
        self.plans: dict[int, DressPlan] = {}
        self.under_way: DressStart | None = None
        self._motions: list[Motion] = []
        self._compared: set[int] = set()

    def plan(self, number: int, position: Position, axis: int) -> DressPlan:
        """What a program does; errors as for `plan_dress`, whose arguments count the first time."""
        if number not in self.plans:
            self.plans[number] = plan_dress(self.programs, number, self.job, self.control, position, axis)
        return self.plans[number]

    def begin(self, event: DressStart) -> None:
        """An execution begins."""
        self.under_way, self._motions = event, []

    def follow(self, motion: Motion) -> None:
        """A motion has been made, which may be one of the execution under way."""
        if self.under_way is not None:
            self._motions.append(motion)

    def end(self, event: DressEnd, axis: int) -> tuple[DressPlan, float]:
        """An execution ends: its plan, and when it began, s; the first one of a program is compared with the plan.

        Raises:
            DressProgramError: the two differ.
        """
        plan, number, begun = self.plans[event.program], event.program, self.under_way
        assert begun is not None
        self.under_way = None
        if number not in self._compared:
            self._compared.add(number)
            require_same(measure_dress(self._motions, number, self.job, axis).plan, plan, number)
        return plan, begun.time

    def called(self, position: Position, axis: int) -> Iterator[tuple[int, int]]:
        """Where M98 calls a dress program: its line, 0 in another file than the main program's, and the number."""
        for line, number in plain_calls(self.programs, block_delete=self.control.block_delete):
            known = number in self.plans
            if known or is_dress_program(self.programs, number, self.job, self.control, position, axis):
                yield line, number
