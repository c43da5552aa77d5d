"""The base classes of all errors and warnings about user input."""

from typing import ClassVar


class GrindError(ValueError):
    """Bad input: program text, job, catalogue, action or file.

    The message is one sentence that names the place and the remedy. The command line prints the message without a
    traceback and exits with the `status` of the class.
    """

    status: ClassVar[int] = 2


class GrindWarning(UserWarning):
    """Warning about input that is used nevertheless. The command line prints each warning once, on one line."""
