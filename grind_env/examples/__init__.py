"""Example part programs with jobs: plates (G82), a keyway (G81) and a rail (G83)."""

from pathlib import Path

from grind_env.errors import GrindError
from grind_env.message_text import did_you_mean, quoted

FOLDER = Path(__file__).parent


def names() -> list[str]:
    """Return the part programs; each has its job beside it."""
    return sorted(path.name for path in FOLDER.glob("*.nc"))


def path(name: str) -> Path:
    """Return the path of an example: a part program, or its job.

    Raises:
        GrindError: there is none by this name.
    """
    known = sorted(each.name for each in FOLDER.iterdir() if each.suffix in (".nc", ".toml"))
    if name not in known:
        raise GrindError(f"there is no example {quoted(name)}{did_you_mean(name, known)}; there are {', '.join(known)}")
    return FOLDER / name
