"""Episodes of a task as part programs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from grind_env.control import Motion, Programs, Source, execute, read
from grind_env.envs.blocks.task_job import conditions, job_of
from grind_env.envs.blocks.task_program import REQUEST, CycleBlock, block_text, program_of
from grind_env.envs.episode_state import Episodes
from grind_env.envs.noise_tape import TapeRow
from grind_env.envs.past_readings import History
from grind_env.envs.program_writer import ProgramWriter, Written
from grind_env.envs.tasks import Task
from grind_env.machine.grind import grind
from grind_env.machine.job import Job, WheelStart
from grind_env.machine.loops.cycle import PartState
from grind_env.machine.program_run import GrindingRun
from grind_env.machine.record import GrindingRecord
from grind_env.process.process_interface import Process

WHEEL_CHANGES, SURFACE = History._fields.index("wheel_changes"), PartState._fields.index("Z")


@dataclass(frozen=True, slots=True)
class TaskWriter(ProgramWriter):
    """Writer of the cycle blocks of a task, with the process and two methods of the simulation."""

    task: Task
    process: Process
    with_full_tapes: Callable[[Episodes], Episodes]
    stroke_times: Callable[[Episodes, int, Sequence[float]], tuple[float, float]]

    def block(self, episodes: Episodes, i: int, speed: float, executions: float, pre_dress: float = 0.0) -> CycleBlock:
        row = TapeRow(*episodes.row(i).tolist())
        kind = self.task.kinds[int(row.kind)]
        surface = 0.0 if kind.starts_part else float(episodes.parts[i, SURFACE])
        here = kind, surface, row.stock, float(speed), int(executions), pre_dress > 0.0
        changes = int(episodes.memory[i, WHEEL_CHANGES])
        block = CycleBlock(*here, episodes.wheel(i), changes, episodes.extra_state(i))
        if self.task.infeed == 0.0 or self.process.before is None:
            return block
        # the process may change the speed of the table
        return block._replace(stroke=self.stroke_times(episodes, i, (speed, executions, pre_dress)))

    def text(self, block: CycleBlock) -> str:
        return block_text(self.task, block)

    def program(self, blocks: Sequence[CycleBlock]) -> str:
        return program_of(self.task, blocks)

    def written(self, episodes: Episodes, i: int, blocks: Sequence[CycleBlock]) -> Written:
        program, found, start = self.program(blocks), blocks[0].wheel, self.task.start
        wheel = WheelStart(
            diameter=found.ds,
            diamond_flat=found.wd,
            wear_flat_area=None if start.wear_flat_area is None else found.A,
            volume_since_dress=None if start.wear_flat_area is None else found.V,
        )
        own = blocks[0].extra_state[: len(self.process.own._fields)]
        parts = tuple(conditions(self.task, self.with_full_tapes(episodes.pick([i])).tape[0]))
        shop = replace(job_of(self.task, blocks), wheel=wheel, parts=parts, process=self.process, own=own)
        return Written(program, shop, request_times(read(program), shop))

    def record(self, episodes: Episodes, i: int, blocks: Sequence[CycleBlock]) -> GrindingRecord:
        program, shop, requests = self.written(episodes, i, blocks)
        return grind(read(program), shop, control=replace(shop.control, operator_dress_at=requests))


def request_times(programs: Programs, job: Job) -> tuple[float, ...]:
    """Return the control times at which the operator asks for a dress, s; for `Control.operator_dress_at`.

    A request follows the last motion or dwell before the dwell with the comment `REQUEST`.
    """
    ahead, before = set(), 0
    for source in programs.main.blocks:
        if REQUEST in source.text:
            ahead.add(before)
        if source.text.startswith("G04") or " Y" in source.text:
            before = source.line
    if not ahead:
        return ()
    control, times = replace(job.control), []
    execution = execute(programs, control)
    run = None if job.process.before is None else GrindingRun(programs, job, control)
    for event in execution:
        if run is not None:  # the process may change the speed of the table
            run.take(event)
            run.tell(execution)
        if isinstance(event, Motion) and event.source is Source.PROGRAM and event.line in ahead:
            control.request_dress()
            # just after the motion, because the table may turn in the moment of its end
            times.append(event.finish + 1e-6)
    return tuple(times)
