"""Optional libraries: an error for a missing one names the extra and its install command."""

from collections.abc import Iterator
from contextlib import contextmanager

from grind_env.errors import GrindError

#: names of the libraries of the extras, by import name
LIBRARIES = {
    "PIL": "Pillow",
    "jinja2": "Jinja2",
    "markupsafe": "Jinja2",
    "matplotlib": "matplotlib",
    "pandas": "pandas",
    "pyarrow": "pyarrow",
    "ray": "Ray",
    "scipy": "SciPy",
    "stable_baselines3": "Stable-Baselines3",
    "torch": "PyTorch",
}


class MissingExtra(GrindError, ImportError):
    """Missing library of an extra."""


@contextmanager
def needing(extra: str, what: str) -> Iterator[None]:
    """Run imports from an extra; `what` begins the sentence about a missing library, such as "reports need".

    Raises:
        MissingExtra: a library of the extra is not installed.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        library = LIBRARIES.get((error.name or "").partition(".")[0])
        if library is None:
            raise
        remedy = f"pip install '.[{extra}]' in the checkout of grind_env"  # the package is in no index
        raise MissingExtra(f"{what} {library}: {remedy}") from None
