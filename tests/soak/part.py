"""Parts of the soak: a part draws case k from seed k and tries it; `Tried` is the result."""

import os
import resource
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from grind_env.errors import GrindError
from grind_env.kernel import compile_at_once

compile_at_once()

End = Literal["accepted", "refused", "fallen"]
MEGABYTE = 1 << 20
PACKAGES = ("grind_env", "agents")


@dataclass(frozen=True, slots=True)
class Tried:
    """Result of a case."""

    end: End  # `refused` if an error sentence refused the case, `fallen` if it failed
    kind: str = ""  # short text, equal for all failures of one kind
    details: str = ""  # text that helps to find the cause of a failure
    sums: Mapping[str, float] = field(default_factory=dict)  # numbers that are added over all cases, by name
    most: Mapping[str, float] = field(default_factory=dict)  # numbers whose maximum over all cases is reported, by name


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """Kind of cases."""

    name: str  # name on the command line and in tables
    attempt: Callable[[int], Tried]  # function that tries the case of a seed
    prepare: Callable[[], object] = lambda: None  # function that prepares each process once, before its cases
    share: float = 1.0  # share of the time, relative to the other parts
    seconds: float = 60.0  # duration after which a case counts as a hang, and its process ends
    growth: float | None = None  # MB by which a process may grow after the first quarter of its time; None for no limit


def attempted(part: Part, seed: int) -> Tried:
    """Try the case of a seed; every exception is a failure."""
    try:
        return part.attempt(seed)
    except BaseException as error:
        return fallen(error)


def fallen(error: BaseException, input_: str = "") -> Tried:
    """Return the result of a case that failed with an unexpected exception."""
    frames = traceback.extract_tb(error.__traceback__)
    own = (each for each in reversed(frames) if any(f"/{name}/" in each.filename for name in PACKAGES))
    last = next(own, frames[-1] if frames else None)
    place = f" in {Path(last.filename).name}:{last.name}" if last else ""
    details = "".join(traceback.format_exception(error))
    return Tried("fallen", f"{type(error).__name__}{place}", f"{details}\n{input_}".rstrip())


def broken(kind: str, details: object) -> Tried:
    """Return the result of a case that broke a promise."""
    return Tried("fallen", kind, str(details))


def refused(error: GrindError) -> Tried:
    """Return the result of a refused case; an error without a printable sentence is a failure."""
    said = str(error)
    if not said or not said.isprintable():
        return broken("no sentence", f"{type(error).__name__}: {said!r}")
    return Tried("refused", sums={type(error).__name__: 1})


def memory() -> float:
    """Return the memory of this process, MB; its maximum so far on systems without /proc."""
    status = Path("/proc/self/statm")
    if status.exists():
        return int(status.read_text().split()[1]) * resource.getpagesize() / MEGABYTE
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def clean(environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return environment variables for commands that import this checkout."""
    root = str(Path(__file__).parents[2])
    return {**environment, "PYTHONPATH": os.pathsep.join([root, environment.get("PYTHONPATH", "")])}
