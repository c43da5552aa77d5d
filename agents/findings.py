"""What was found in a cell, kept as JSON beside what stands for the code that found it."""

import json
from pathlib import Path
from typing import Any

from grind_env.files import read_text
from grind_env.policies.tuned import write_whole


def kept(path: Path, code: str) -> Any:
    """What the same code has found before; None if there is nothing of it."""
    held = json.loads(read_text(path)) if path.exists() else {}
    return held.get("found") if held.get("code") == code else None


def keep(path: Path, code: str, found: Any) -> Any:
    """Keep what was found, whole or not at all; it comes back as it is read the next time."""
    text = json.dumps({"code": code, "found": found})
    write_whole(path, text)
    return json.loads(text)["found"]
