"""Entry points: the events of a part program, and the motions of a dress program by itself."""

import math
from collections.abc import Iterator

from grind_env.control.block_decoding import decode
from grind_env.control.block_words import Block
from grind_env.control.control_settings import Control
from grind_env.control.cycle_planning import ModalWords
from grind_env.control.errors import ControlError
from grind_env.control.events import CyclePlan, Event, Motion, Position, placed
from grind_env.control.interpreter import Interpreter
from grind_env.control.modal_state import Modes
from grind_env.control.program_reader import Programs
from grind_env.control.reciprocation import Reciprocation


class Execution(Iterator[Event]):
    """The events of a part program under execution; between two of them the caller may act on the control."""

    def __init__(self, programs: Programs, control: Control) -> None:
        self._interpreter = Interpreter(programs, control)
        self._events = self._interpreter.run()

    def __next__(self) -> Event:
        return next(self._events)

    @property
    def modes(self) -> Modes:
        """The modes in force; after the end of the program those of power-up (10-23)."""
        return self._interpreter.mover.modes

    @property
    def position(self) -> Position:
        """Return the position of the axes, or their target beside reciprocation, mm."""
        return self._interpreter.timeline.position

    @property
    def table(self) -> Reciprocation | None:
        """Return the reciprocating table; None if the table rests, and during a dress."""
        return self._interpreter.timeline.reciprocation

    @property
    def remembered(self) -> ModalWords:
        """Words of the cycles so far, which later cycles may omit."""
        return self._interpreter.table.memory

    @property
    def dependent(self) -> int | None:
        """First `#` variable read whose value depends on the wheel, its dresses or the end of a cycle, or None."""
        return self._interpreter.system.dependent or self._interpreter.variables.dependent

    @property
    def unread(self) -> tuple[str, ...]:
        """Return a sentence for each given variable that nothing has read so far."""
        return tuple(self._interpreter.variables.unread())

    @property
    def changing_dress(self) -> int | None:
        """Return the first dress program that changed offsets, other tables, wheel or coolant."""
        return self._interpreter.interruptions.changing_dress

    @property
    def over(self) -> bool:
        """Return whether the text is finished; the table then only stops, or makes the strokes of a running G81."""
        return self._interpreter.over

    def move_axis(self, axis: int, coordinate: float) -> None:
        """Set the coordinate of an axis that has just come to rest, mm: the other end of its strokes or crossover."""
        self._interpreter.timeline.position = placed(self.position, {axis: coordinate})

    def choose(self, **words: str) -> None:
        """Replace numbers in the block announced by the last `CycleAhead` or `FeedAhead`: ``E="9000"``."""
        self._interpreter.chosen = words

    def planned(self, block: Block) -> CyclePlan:
        """Return the plan of the cycle block announced by the last `CycleAhead`, with its own words.

        Raises:
            ControlError: the block is faulty.
        """
        control = self._interpreter
        return control.table.planned(decode(block, self.modes, control.control.number_format))[0]

    def set_wheel_radius(self, radius: float) -> None:
        """Write the present radius of the wheel, mm, into entry 33 of the radius table (15-11).

        Raises:
            ControlError: setting, not a finite number above 0.
        """
        if not 0.0 < radius < math.inf:
            raise ControlError("setting", f"a wheel radius of {radius} is impossible; it must be above 0 mm")
        self._interpreter.mover.tooling.wheel_radius = radius

    def set_table(self, share: float, dwell: float) -> None:
        """Set, from the next stroke on, the share of E that the table reaches, and its rest at a reversal, s."""
        self._interpreter.timeline.share, self._interpreter.timeline.dwell = share, dwell

    def forget_dresses(self) -> None:
        """Have every dress program executed once more, as its path changes from now on (`Control.whole_cycles`)."""
        self._interpreter.interruptions.known_dresses.clear()


def execute(programs: Programs, control: Control | None = None) -> Execution:
    r"""Execute the main program of a file.

    Args:
        programs: what `read` or `read_file` returned.
        control: settings and operator panel; the defaults if None.

    Returns:
        the events in the order in which they end, each pick behind its stroke. Taking the next event raises a
        `ControlError` when execution reaches a faulty block.

    Example:
        >>> from grind_env.control import Line, execute, read
        >>> events = execute(read("G01 X10. F60.\nX20. Y5.\nM30"))
        >>> [event.end for event in events if isinstance(event, Line)]
        [(10.0, 0.0, 0.0), (20.0, 5.0, 0.0)]
    """
    return Execution(programs, control or Control())


def dress_program_moves(
    programs: Programs,
    number: int,
    control: Control | None = None,
    start: Position = (0.0, 0.0, 0.0),
    modes: Modes | None = None,
) -> list[Motion]:
    """Return the motions of one execution of a dress program, its retrace included.

    Args:
        programs: file that contains the dress program or lies beside its file.
        number: O number of the dress program.
        control: settings; the defaults if None.
        start: position at which the dress interrupts the program, mm.
        modes: modes in force there; if None, the modes at power-up, which have no F.

    Raises:
        ControlError: the dress program does not exist or is faulty.
    """
    interpreter = Interpreter(programs, control or Control())
    interpreter.timeline.position = start
    if modes is not None:
        interpreter.mover.modes = modes
    if programs.find(number) is None:
        message = f"O{number} names no program; it must be in {programs.name} or beside it"
        raise ControlError("program-not-found", message)
    return [event for event in interpreter.interruptions.dress(number, "pre") if isinstance(event, Motion)]
