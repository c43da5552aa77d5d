"""A module in which a user defines machines."""

from pathlib import Path

import pytest

OWN = """
from typing import NamedTuple
from grind_env.kernel import inlined
from grind_env.plants import Family, Plant, Range
from grind_env.evidence import Basis, Evidence
from grind_env.process.process_interface import PROCESS, Hook, composed

class Own(NamedTuple):
    sticky_by: float = 0.0

@inlined
def before(wheel, own, p, drive, moment):
    return wheel, own, p, drive

hook = Hook(before, Own)
MINE = Plant(name="mine", process=composed(PROCESS, hook), own=(*PROCESS.own(), 0.25))
BY = Range(field="sticky_by", what="sticks", low=1.0, high=2.0, basis=Basis(Evidence.OWN, "mine"))
STICKY = Family(name="sticky", what="it sticks", ranges=(BY,), hook=hook)
WRONG = Family(name="wrong", what="draws what it does not remember", ranges=(BY,))
NUMBER = 7
"""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the name of an importable module in which a user defines machines."""
    (tmp_path / "my_machines.py").write_text(OWN)
    (tmp_path / "my_mistake.py").write_text("1 / 0\n")
    (tmp_path / "my_end.py").write_text("raise SystemExit('good bye')\n")
    monkeypatch.syspath_prepend(tmp_path)
    return "my_machines"
