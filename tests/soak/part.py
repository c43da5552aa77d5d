"""What a part of the soak is: case k is drawn from seed k and tried, and Tried says how it ended."""

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
    """How a case ended.

    Attributes:
        end: refused is one by a sentence.
        kind: the same for all that have fallen in the same way.
        details: what is needed to see why it fell.
        sums: what is counted over all cases, by name.
        most: of what the largest is kept.
    """

    end: End
    kind: str = ""
    details: str = ""
    sums: Mapping[str, float] = field(default_factory=dict)
    most: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """One kind of trial.

    Attributes:
        name: on the command line and in tables.
        attempt: tries the case of a seed.
        prepare: is called once in each process, for what no case should wait for.
        share: of the time, beside the shares of the other parts.
        seconds: after which a case hangs, and its process is ended.
        growth: MB of memory that a process may grow by after its first quarter; None if that is not judged.
    """

    name: str
    attempt: Callable[[int], Tried]
    prepare: Callable[[], object] = lambda: None
    share: float = 1.0
    seconds: float = 60.0
    growth: float | None = None


def attempted(part: Part, seed: int) -> Tried:
    """The case of a seed; whatever it raises has made it fall."""
    try:
        return part.attempt(seed)
    except BaseException as error:
        return fallen(error)


def fallen(error: BaseException, input_: str = "") -> Tried:
    """What has ended with an error that it should not have ended with."""
    frames = traceback.extract_tb(error.__traceback__)
    own = (each for each in reversed(frames) if any(f"/{name}/" in each.filename for name in PACKAGES))
    last = next(own, frames[-1] if frames else None)
    place = f" in {Path(last.filename).name}:{last.name}" if last else ""
    details = "".join(traceback.format_exception(error))
    return Tried("fallen", f"{type(error).__name__}{place}", f"{details}\n{input_}".rstrip())


def broken(kind: str, details: object) -> Tried:
    """What has not kept a promise."""
    return Tried("fallen", kind, str(details))


def refused(error: GrindError) -> Tried:
    """What was refused; in no sentence, it has fallen."""
    said = str(error)
    if not said or not said.isprintable():
        return broken("no sentence", f"{type(error).__name__}: {said!r}")
    return Tried("refused", sums={type(error).__name__: 1})


def memory() -> float:
    """Memory of this process, MB; where the system does not tell, the most it has had."""
    status = Path("/proc/self/statm")
    if status.exists():
        return int(status.read_text().split()[1]) * resource.getpagesize() / MEGABYTE
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def clean(environment: Mapping[str, str] = os.environ) -> dict[str, str]:
    """An environment for commands, in which this checkout is imported."""
    root = str(Path(__file__).parents[2])
    return {**environment, "PYTHONPATH": os.pathsep.join([root, environment.get("PYTHONPATH", "")])}
