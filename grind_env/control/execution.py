"""Entry points: the events of a part program, and the motions of a dress program by itself."""

from collections.abc import Iterator

from grind_env.control.control import Control
from grind_env.control.errors import ControlError
from grind_env.control.interpreter import Interpreter
from grind_env.control.motions import Event, Motion, Position
from grind_env.control.reader import Programs


def execute(programs: Programs, control: Control | None = None) -> Iterator[Event]:
    """Execute the main program of a file.

    Args:
        programs: what `read` or `read_file` returned.
        control: settings; the defaults if None.

    Yields:
        events in the order in which they end.

    Raises:
        ControlError: when execution reaches a faulty block; what came before has been yielded.
    """
    return Interpreter(programs, control or Control()).run()


def dress_program_moves(
    programs: Programs, number: int, control: Control | None = None, start: Position = (0.0, 0.0, 0.0)
) -> list[Motion]:
    """The motions of one execution of a dress program, its retrace included.

    It is executed from power-up modes, so it must set its own F.

    Args:
        programs: the file that holds it, or that it lies beside.
        number: its O number.
        control: settings; the defaults if None.
        start: where the dress interrupts, mm.

    Raises:
        ControlError: it does not exist or is faulty.
    """
    interpreter = Interpreter(programs, control or Control())
    interpreter.timeline.position = start
    if programs.find(number) is None:
        raise ControlError("program-not-found", f"O{number} is not in {programs.name} or beside it")
    return [event for event in interpreter.dress(number, "pre") if isinstance(event, Motion)]
