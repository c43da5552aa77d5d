"""The dress programs of a run: the effect of each, checked to be the same wherever a cycle calls it.

The effect of the first execution at a station holds for all, because a control need not repeat a known dress.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from grind_env.control import Control, CycleStart, DressEnd, DressStart, Motion, Position, Programs
from grind_env.control.control_settings import ORIGIN, WHEEL_RADIUS
from grind_env.control.modal_state import Modes
from grind_env.machine.dress import dress_run as dress_program
from grind_env.machine.dress.mounted_wheel import first_diameter
from grind_env.machine.job import Job


class DressPrograms:
    """Known dress programs of a run, by O number.

    Other modes, tables or values of `#` variables may change a program, so it is run by itself once for each of these.
    A program with the same effect under other modes or values keeps the time of its first run: only its way to the
    diamond begins elsewhere.
    """

    def __init__(self, programs: Programs, job: Job, control: Control) -> None:
        self.programs, self.job, self.control = programs, job, control
        self.plans: dict[int, dress_program.DressPlan] = {}  # effect of each program run by itself
        self.missed: dict[int, Motion | None] = {}  # first pass of each that misses the diamond; None if none does
        self.under_way: DressStart | None = None  # start of the current execution; None without one
        self._runs: dict[tuple[object, ...], list[dress_program.DressRun]] = {}
        self._known: dict[tuple[object, ...], dress_program.DressRun] = {}
        self._found: dict[int, dress_program.DressRun] = {}
        self._modes: Modes | None = None  # of the last cycle
        self._motions: list[Motion] = []
        self._gone: set[tuple[int, int]] = set()  # program and station of each judged execution

    def run(self, number: int, position: Position, event: CycleStart) -> dress_program.DressRun:
        """Return the effect of a dress program if a cycle begins at a position, mm."""
        tables = number, tuple(event.origins.items())
        key = *tables, tuple(sorted(event.variables.items())), event.modes
        if key not in self._known:
            control = replace(  # with the tables and variables that the dress program finds in the cycle
                self.control,
                variables=event.variables,
                work_offsets=event.origins,
                external_offset=ORIGIN,
                radii={WHEEL_RADIUS: 0.5 * first_diameter(self.job), **self.control.radii},
            )
            found = dress_program.run_dress(
                self.programs, number, self.job, control, position, event.plan.axis, event.modes
            )
            runs = self._runs.setdefault(tables, [])
            same = next((run for run in runs if dress_program.is_same(run.plan, found.plan)), None)
            if same is None:
                runs.append(found)
            self._known[key] = same or found
        run, self._modes = self._known[key], event.modes
        if self._found.get(number) is not run:
            if self.plans.get(number) != run.plan:
                self._gone = {each for each in self._gone if each[0] != number}
            self.plans[number], self._found[number], self.missed[number] = run.plan, run, self._missed(run)
        return run

    def file(self, number: int) -> str:
        program = self.programs.find(number)
        return self.programs.name if program is None else program.place.file

    def is_first_at_station(self, number: int, station: int) -> bool:
        return (number, station) not in self._gone

    def begin(self, event: DressStart) -> None:
        self.under_way, self._motions = event, []

    def follow(self, motion: Motion) -> None:
        if self.under_way is not None:
            self._motions.append(motion)

    def end(self, event: DressEnd, axis: int, station: int) -> tuple[dress_program.DressPlan, float, Sequence[Motion]]:
        """End an execution; return its effect, its start, s, and its motions (empty after the first at a station).

        The first execution at a station is compared with the program run by itself.
        """
        plan, number, begun = self.plans[event.program], event.program, self.under_way
        assert begun is not None
        self.under_way = None
        by_itself, new = self._found[number], self.is_first_at_station(number, station)
        if new or by_itself.control.variables:
            self._gone.add((number, station))
            run = dress_program.measure_dress(
                tuple(self._motions), number, self.job, axis, by_itself.control, by_itself.modes
            )
            dress_program.require_same(run.plan, plan, number)
            self.missed[number] = self._missed(run)
        # later executions are not judged: a control that knows the program makes no motions
        return plan, begun.time, self._motions if new else ()

    def called(self, position: Position, axis: int) -> Iterator[tuple[int, int]]:
        """Yield each call of a dress program by M98: its line (0 outside the main program's file) and its number.

        Programs called by a dress program belong to it.
        """
        calls = tuple(dress_program.plain_calls(self.programs, block_delete=self.control.block_delete))
        parts = set(self.plans)
        while more := {called for caller, _, called in calls if caller in parts} - parts:
            parts |= more
        for caller, line, number in calls:
            if caller not in parts and (number in self.plans or self._would_dress(number, position, axis)):
                yield line, number

    def _would_dress(self, number: int, position: Position, axis: int) -> bool:
        try:
            run = dress_program.run_dress(self.programs, number, self.job, self.control, position, axis, self._modes)
        except dress_program.DressProgramError:
            return False
        return not run.advances

    def _missed(self, run: dress_program.DressRun) -> Motion | None:
        diamond, wheel = self.job.diamond, self.job.setup.wheel
        if diamond is None:
            return None
        return dress_program.missed_pass(run, diamond.tip, 0.5 * first_diameter(self.job), wheel.width)
