"""The common root of every error that a user's input can cause."""


class GrindError(ValueError):
    """Bad input: program text, job, catalogue, action or file.

    The message is one sentence that names the place and the remedy. The command line prints it and exits
    with status 2; it never shows a traceback for one of these.
    """
