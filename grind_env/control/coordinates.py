"""Work coordinate systems, their shift by G92, the external offset and length offsets (11-10, lathe 11-8)."""

from grind_env.control import numbers
from grind_env.control.block_decoding import Command
from grind_env.control.control_settings import ORIGIN, Control
from grind_env.control.errors import ControlError
from grind_env.control.events import Position, placed
from grind_env.control.modes import WORK_SYSTEMS
from grind_env.control.motion_paths import AXES, displaced
from grind_env.control.program_reader import HIGHEST_PROGRAM


class WorkSystems:
    """Origin of the program on the machine."""

    def __init__(self, control: Control) -> None:
        # origins of G54 to G59.3 by their code, mm
        self.offsets = {system: control.work_offsets.get(system, ORIGIN) for system in WORK_SYSTEMS}
        for code in control.work_offsets:
            if code not in self.offsets:
                raise ControlError(
                    "setting", f"work_offsets names {code}; the systems are {WORK_SYSTEMS[0]} to {WORK_SYSTEMS[-1]}"
                )
        self.external = control.external_offset  # shift of all work systems by the external offset, mm
        self.shift = ORIGIN  # shift by G92, mm
        self.local = ORIGIN  # shift of all work systems by G52, mm
        self.length = ORIGIN  # the active length offset, mm
        self.wear = ORIGIN  # shift towards the part by the depth of dresses, mm

    def origin(self, system: str) -> Position:
        """Return the machine coordinates of the program's origin in a work system, mm."""
        parts = (self.offsets[system], self.external, self.shift, self.local, self.length, self.wear)
        x, y, z = map(sum, zip(*parts, strict=True))
        return x, y, z

    @property
    def origins(self) -> dict[str, Position]:
        return {system: self.origin(system) for system in self.offsets}

    def follow_wheel(self, axis: int, way: float) -> None:
        """Shift the origin along an axis, towards the part, by the depth that a dress has removed, mm."""
        self.wear = placed(self.wear, {axis: self.wear[axis] + way})

    def load(self, command: Command) -> None:
        """G10 L2: write axis words into the table of a work system, under G91 add them (lathe 11-8)."""
        block, words = command.block, command.words
        command.allow_only("LPOXYZ", "a G10 block")
        for letter, meaning in (("L", "L2"), ("P", "P")):
            if letter not in words:
                message = f"G10 lacks {meaning}; G10 L2 P1 to P{len(WORK_SYSTEMS)} loads a work system"
                raise command.error("missing-parameter", message)
        if numbers.integer(block, words["L"], 0, 99) != 2:
            raise command.error("not-supported", f"G10 {words['L']} is not supported; G10 L2 loads work systems", "L")
        system = WORK_SYSTEMS[numbers.integer(block, words["P"], 1, len(WORK_SYSTEMS)) - 1]
        scope = numbers.integer(block, words["O"], 0, HIGHEST_PROGRAM) if "O" in words else 0
        diameter = {1: False, 2: True}.get(scope, command.modes.diameter)
        letters = list(words)
        axes = [letter for letter in AXES if letter in words]
        for letter in "LPO":
            if letter in words and any(letters.index(axis) < letters.index(letter) for axis in axes):
                raise command.error(
                    "block-format", f"{words[letter]} follows an axis word; L, P and O come first", letter
                )
        offset = self.offsets[system]
        for letter in axes:
            raw = numbers.length(block, words[letter], command.modes.inch, command.number_format)
            way = 0.5 * raw if letter == "X" and diameter else raw
            axis = AXES.index(letter)
            to = displaced(offset[axis], way) if command.lengths[letter].incremental else way
            offset = placed(offset, {axis: to})
        self.offsets[system] = offset

    def preset(self, command: Command, position: Position) -> None:
        """G92: shift the origin so that `position` gets the coordinates of the axis words."""
        command.allow_only(AXES, "a G92 block")
        if not command.lengths:
            message = "G92 lacks X, Y or Z; it takes the coordinates that the present position shall have"
            raise command.error("missing-parameter", message)
        origin = self.origin(command.modes.work_system)
        for letter, value in command.lengths.items():
            axis = AXES.index(letter)
            to = displaced(self.shift[axis], position[axis] - origin[axis] - value.mm)
            self.shift = placed(self.shift, {axis: to})

    def set_local(self, command: Command) -> None:
        """G52: set the local origin relative to the work system; earlier G52 blocks have no effect (D)."""
        command.allow_only(AXES, "a G52 block")
        if not command.lengths:
            message = (
                "G52 lacks X, Y or Z; it takes the way from the work system's origin to the local one, 0 to end it"
            )
            raise command.error("missing-parameter", message)
        self.local = placed(self.local, {AXES.index(letter): value.mm for letter, value in command.lengths.items()})

    def cancel_preset(self, command: Command) -> None:
        command.allow_only("", "a G92.1 block")
        self.shift = ORIGIN
