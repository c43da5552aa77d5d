"""`ControlError`, which any function of the control may raise, and the place of a block that it names."""

from typing import NamedTuple

from grind_env.errors import GrindError


class ControlError(GrindError):
    """Error in a part program or setting that the control refuses.

    Attributes:
        name: short code such as ``block-format`` or ``missing-parameter``.
        message: one sentence: the mistake, and legal values.
        block: N word of the block, or its line number when it has none; None for a file as a whole.
        line: line in the file, from 1.
        column: column in that line, from 1.
        file: name of the file.
    """

    def __init__(
        self,
        name: str,
        message: str,
        block: int | None = None,
        line: int | None = None,
        column: int | None = None,
        file: str = "",
    ) -> None:
        self.name, self.message = name, message
        self.block, self.line, self.column, self.file = block, line, column, file
        place = ":".join(str(part) for part in (file or None, line, column) if part is not None)
        super().__init__(f"{place}: {message} [{name}]" if place else f"{message} [{name}]")


class Place(NamedTuple):
    """Place of a block: file, line and column from 1, and its N word or else its line number."""

    file: str
    line: int
    column: int
    block: int

    def error(self, name: str, message: str, column: int | None = None) -> ControlError:
        """Return an error at this place, or at another column of it."""
        return ControlError(name, message, self.block, self.line, column or self.column, self.file)
