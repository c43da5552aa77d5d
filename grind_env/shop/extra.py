"""What needs the libraries of the extra [shop], and says so where they are not installed."""

from collections.abc import Iterator
from contextlib import contextmanager

from grind_env.errors import GrindError

LIBRARIES = {"jinja2": "Jinja2", "markupsafe": "Jinja2", "pandas": "pandas", "plotly": "plotly", "scipy": "SciPy"}


class MissingExtra(GrindError):
    """Something that needs a library which is not installed."""


@contextmanager
def shop_extra(what: str) -> Iterator[None]:
    """Import what is of the extra in here; `what` begins the sentence on one that is missing: "reports need".

    Raises:
        MissingExtra: a library of the extra is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        library = LIBRARIES.get((error.name or "").partition(".")[0])
        if library is None:
            raise
        raise MissingExtra(f"{what} {library}; install grind_env[shop]") from None
