"""`make setup` and the README's commands install the same versions everywhere: each of them is pinned."""

import re
import sys
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PINNED = re.compile(r"^([\w.-]+)==\S+?(; .*)?$", re.MULTILINE)


def needed(name: str, extras: frozenset[str], known: set[tuple[str, str]]) -> set[str]:
    """Return the names of all direct and indirect requirements of an installed distribution."""
    found = set[str]()
    for extra in {"", *extras}:
        if (name, extra) in known:
            continue
        known.add((name, extra))
        for each in map(Requirement, metadata.requires(name) or []):
            if each.marker is None or each.marker.evaluate({"extra": extra}):
                found |= {canonicalize_name(each.name), *needed(each.name, frozenset(each.extras), known)}
    return found


@pytest.mark.skipif(sys.version_info < (3, 11), reason="pinned are the versions for Python 3.11 and newer")
@pytest.mark.skipif(sys.platform != "linux", reason="on other systems other packages are needed, too")
def test_every_installed_requirement_is_pinned() -> None:
    text = (Path(__file__).parents[1] / "constraints.txt").read_text("utf-8")
    pinned = [canonicalize_name(name) for name, _ in PINNED.findall(text)]
    assert len(pinned) == len(set(pinned))
    found = needed("grind_env", frozenset({"dev"}), set()) - {"grind-env"}
    assert len(found) > 100 and found <= set(pinned)
