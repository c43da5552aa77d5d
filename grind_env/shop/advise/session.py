"""A session at the machine: give advice, take readings, and save both."""

import json
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

from grind_env.files import shown
from grind_env.shop.advise.adviser import Advice, Adviser
from grind_env.shop.advise.forecast_comparison import Shadow
from grind_env.shop.advise.operator_readings import MachineReadings, ReadingError, check_readings, readings_of
from grind_env.shop.advise.reading_sources import ReadingSource, ReadingsRow
from grind_env.shop.advise.state import ANEW, AdviceOrigin, AdvisedBlock, StateError, read_state, write_log, write_state
from grind_env.shop.advise.variables_file import write_values


@dataclass(frozen=True, kw_only=True)
class Files:
    """Files of a session."""

    state: Path  #: state to resume from
    log: Path  #: log with a row for each block
    values: Path | None = None  #: file of paramacro variables; None for none


@dataclass(kw_only=True)
class Session:
    """Session that gives advice before every block, and takes its readings."""

    adviser: Adviser  #: adviser before its first block
    origin: AdviceOrigin  #: inputs behind the advice
    files: Files  #: where the session is saved
    source: ReadingSource  #: source of the readings
    say: Callable[[str], None]  #: function that prints a text
    #: whether a row is for a part instead of a block: all blocks of a part are then advised before it, and only its
    #: last block has readings
    by_part: bool = False
    as_json: bool = False  #: whether advice is printed as JSON objects, one a line
    why: bool = False  #: whether the basis of each reason is printed
    shadow: Shadow | None = None  #: comparison while somebody else decides; None if the advice is followed
    steps: list[AdvisedBlock] = field(default_factory=list)
    given: list[Advice] = field(default_factory=list)

    def begin(self) -> None:
        """Begin anew: write a state file without blocks."""
        write_state(self.files.state, self.origin, [])

    def resume(self) -> None:
        """Give the adviser the content of the state file.

        Raises:
            GrindError: the file is damaged, is of another batch, or has other advice.
        """
        for number, step in enumerate(read_state(self.files.state, self.origin)):
            advice = self.adviser.advice
            if advice is None or advice.words != step.words:
                raise StateError(f"{self.files.state} was written by another version, which advised otherwise: {ANEW}")
            try:
                check_readings(
                    step.readings, self.adviser.simulation, number, f"{shown(self.files.state)}, block {number + 1}"
                )
            except ReadingError as error:
                raise StateError(f"{error}; {ANEW}") from None
            self._take(advice, step.readings)
            self.steps.append(step)
        if self.steps:
            write_log(self.files.log, self.adviser.simulation, self.steps)

    def run(self) -> None:
        """Advise until the batch is over, or there are no more readings.

        Raises:
            GrindError: a reading is refused, or a file cannot be written; earlier readings stay saved.
        """
        if self.source.repeats_rows:
            self._check_repeated_rows()
        try:
            over = self._advise()
        except KeyboardInterrupt:
            self._print_comparison()  # the user of a shadow session may stop at any time
            raise
        self._print_comparison()
        if not over:
            return
        further = self.source.next("") if self.source.repeats_rows and not self.source.accepts_corrections else None
        if further is not None:
            what = f"{further.place} is of no block of this batch, which is over: nothing is read from there on"
            self._tell({"ignored": what}, what)
        if not self.as_json:
            self.say(f"the batch is finished: {len(self.steps)} blocks, log in {self.files.log}")

    def _advise(self) -> bool:
        """Advise block by block; return True at the end of the batch, False if the readings end earlier."""
        while (advice := self.adviser.advice) is not None:
            self._show(advice)
            ends = self.adviser.simulation.blocks[advice.block].finished > 0
            if self.by_part and not ends:
                # saved with the row of the part: a session that is stopped before shows all advice of the part again
                self._add_step(advice, MachineReadings())
                continue
            readings = self._read(advice)
            if readings is None:
                return False
            self._add_step(advice, readings)
            write_state(self.files.state, self.origin, self.steps)
            write_log(self.files.log, self.adviser.simulation, self.steps)
        return True

    def _print_comparison(self) -> None:
        """Print forecasts beside readings, of a shadow session."""
        if self.shadow is not None:
            self._tell(self.shadow.document(), *self.shadow.lines())

    def _tell(self, data: object, *lines: str) -> None:
        for text in [json.dumps(data)] if self.as_json else lines:
            self.say(text)

    def _read(self, advice: Advice) -> MachineReadings | None:
        while True:
            try:
                row = self.source.next(self._awaited(advice))
                return None if row is None else self._checked(row, advice.block)
            except ReadingError as error:
                if not self.source.accepts_corrections:
                    raise
                self.source.refused()
                self._tell({"refused": str(error)}, str(error))

    def _checked(self, row: ReadingsRow, number: int) -> MachineReadings:
        readings = readings_of(row.table, row.place)
        check_readings(readings, self.adviser.simulation, number, row.place)
        return readings

    def _awaited(self, advice: Advice) -> str:
        part = self.adviser.simulation.blocks[advice.block].part + 1
        return f"readings of part {part}" if self.by_part else f"readings of block {advice.block + 1}"

    def _check_repeated_rows(self) -> None:
        """Check that the source repeats the rows of the saved blocks; a `StateError` names a missing or other one."""
        for number, step in enumerate(self.steps):
            if self.by_part and not self.adviser.simulation.blocks[number].finished:
                continue
            row = self.source.next("")
            if row is None:
                raise StateError(f"{self.files.state} knows block {number + 1}, which the measurements lack: {ANEW}")
            if self._checked(row, number) != step.readings:
                raise StateError(f"{row.place} says something else of block {number + 1} than it did before: {ANEW}")

    def _add_step(self, advice: Advice, readings: MachineReadings) -> None:
        self._take(advice, readings)
        now = datetime.now().isoformat(timespec="seconds")
        self.steps.append(AdvisedBlock(time=now, words=advice.words, readings=readings))

    def _take(self, advice: Advice, readings: MachineReadings) -> None:
        self.adviser.take(readings)
        self.given.append(advice)
        if self.shadow is not None and self.adviser.watch is not None:
            self.shadow.add(self.adviser.watch, self.adviser.simulation.blocks[advice.block].part)

    def _show(self, advice: Advice) -> None:
        if self.files.values is not None:
            write_values(self.files.values, self.adviser.simulation, [*self.given, advice])
        self._tell(as_data(self.adviser, advice), *lines_of(self.adviser, advice, why=self.why))


def as_data(adviser: Adviser, advice: Advice) -> dict[str, object]:
    """Return advice as an object of JSON."""
    place = {"block": advice.block + 1, "part": adviser.simulation.blocks[advice.block].part + 1}
    return {**place, **advice.words, "reason": {"power": adviser.power, "text": adviser.reason}}


def lines_of(adviser: Adviser, advice: Advice, *, why: bool = False) -> list[str]:
    """Return the advice as one line; with `why`, further lines explain the reason."""
    block = adviser.simulation.blocks[advice.block].block
    label = re.match(r"\s*(N\s*\d+)", block.source.text.upper())
    name = label[1].replace(" ", "") if label else f"line {block.source.line}"
    words = " ".join(f"{letter}{value}" for letter, value in advice.words.items())
    mine = "would be " if adviser.shadow else ""
    part = adviser.simulation.blocks[advice.block].part + 1
    line = f"part {part}, {name}: {mine}{words} - {adviser.reason}"
    power = [] if adviser.power is None else [f"  a peak power of {0.001 * adviser.power:.2f} kW is expected"]
    return [line, *power, *(f"  {sentence}" for sentence in adviser.details())] if why else [line]
