"""What is seen of cells that are worked on, wherever that is: bars of how far they are, and why one failed."""

from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, Generic, Protocol, TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn


class Request(Protocol):
    """How cells are worked on."""

    @property
    def size(self) -> int:
        """What a cell tells to be done from its beginning to its end."""


CellT = TypeVar("CellT")
RequestT = TypeVar("RequestT", bound=Request)
FoundT = TypeVar("FoundT")
Work = Callable[[CellT, RequestT, Callable[[int], object]], FoundT]
"""What a process does with a cell; it tells how much of the size of the request is done."""


class Board(Generic[CellT]):
    """The bars of cells, and what has become of those that have ended.

    Args:
        cells: all of them.
        size: of each.
        console: where they are shown.
    """

    def __init__(self, cells: Sequence[CellT], size: int, console: Console) -> None:
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
        self._cells, self._size, self._console = cells, size, console
        self._progress = Progress(*columns, console=console, transient=True)
        self._total = self._progress.add_task("cells", total=len(cells))
        self._bars: dict[CellT, TaskID] = {}
        self._answers: dict[CellT, Any] = {}

    def __enter__(self) -> "Board[CellT]":
        self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()

    def begin(self, cell: CellT, place: str = "") -> None:
        """A cell is begun; `place` says where, if that is to be told."""
        self._bars[cell] = self._progress.add_task(f"{cell} {place}".rstrip(), total=self._size)

    def advance(self, cell: CellT, done: int) -> None:
        """So much more of a cell is done."""
        self._progress.advance(self._bars[cell], done)

    def lose(self, cell: CellT, why: str) -> None:
        """A cell has to begin again."""
        self._say(cell, why)
        self._leave(cell)

    def end(self, cell: CellT, answer: Any) -> None:
        """A cell has ended: with a sentence if it failed, else with what was found."""
        self._answers[cell] = answer
        if isinstance(answer, str):
            self._say(cell, answer)
        self._leave(cell)
        self._progress.advance(self._total)

    def _say(self, cell: CellT, text: str) -> None:
        self._console.print(f"{cell}: {text}", highlight=False, markup=False, soft_wrap=True)

    def _leave(self, cell: CellT) -> None:
        if cell in self._bars:
            self._progress.remove_task(self._bars.pop(cell))

    def ended(self) -> tuple[list[Any], dict[CellT, str]]:
        """What was found, in the order of the cells, and one sentence of each cell that failed."""
        answers = self._answers
        found = [answers[cell] for cell in self._cells if not isinstance(answers[cell], str)]
        return found, {cell: answer for cell, answer in answers.items() if isinstance(answer, str)}


def sentence(error: Exception) -> str:
    """What to tell the user about a cell that failed."""
    text = " ".join(str(error).split())
    known = type(error).__module__.partition(".")[0] in ("grind_env", "agents")
    return text if known else f"{type(error).__name__}: {text}"
