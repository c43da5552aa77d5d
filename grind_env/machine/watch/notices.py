"""What has been told of a run: of each subject once in each block."""


class Notices:
    """Collects sentences; `muted` while what would be told follows from what has been."""

    def __init__(self, program: str) -> None:
        self.program = program
        self.sentences: list[str] = []
        self.muted = False
        self._told: set[tuple[str, str, int]] = set()

    def tell(self, line: int, subject: str, text: str | None, file: str | None = None) -> None:
        """Say something of a subject, unless it is None, in a line of the program or of a file; line 0 is all of it."""
        file = file or self.program
        if text is not None and not self.muted and (subject, file, line) not in self._told:
            self._told.add((subject, file, line))
            self.sentences.append(f"{file}:{line}: {text}" if line else f"{file}: {text}")
