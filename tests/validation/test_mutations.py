"""Mutation tests: laws are changed one at a time, and the rows that notice the change are counted."""

import os
import subprocess
import sys

import pytest

from grind_env.errors import GrindError
from grind_env.validation import __main__ as module
from grind_env.validation.mutations import LAWS, Law, MutationResult, mutate

FLATS = """
from grind_env.validation.mutations import LAWS, Rig, changed, load_catalogue
for law in LAWS[:2]:
    with changed(law):
        print(*(Rig(load_catalogue()).fresh(depth=depth).wheel.A for depth in (0.005, 0.02)))
"""


def test_each_law_finds_its_text_once_and_its_change_compiles():
    for law in LAWS:
        compile(law.source(), law.function, "exec")
    with pytest.raises(GrindError, match=r"laws.csv: other: equations.dressing.severity has 'colour' 0 times"):
        Law("other", "equations.dressing.severity", "colour", "grey").source()


def test_a_changed_law_holds_until_its_context_ends():
    plain = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    A = list(map(float, subprocess.check_output([sys.executable, "-c", FLATS], env=plain, text=True).split()))
    assert (A[0] / A[1], A[2] / A[3]) == pytest.approx((0.25 + 0.75 * 2**0.5, 1.75))  # of .25 + .75 s^(-1/2)


@pytest.mark.parametrize(
    ("decides", "known", "rows", "status"),
    [("", "", 0, 0), ("E", "", 1, 1), ("E", "", 2, 0), ("E", "nobody has measured it", 1, 0), ("E", "so", 2, 1)],
)
def test_mutate_exits_with_1_after_an_unexpected_result(decides, known, rows, status, monkeypatch, capsys):
    found = MutationResult(Law("changed", "", "", "", decides, known), ("flats", "energy")[:rows])
    monkeypatch.setattr(module, "mutate", lambda: [found])
    assert module.main(["--mutate"]) == status
    told = ("changed", known, "; ".join(found.rows), f"{status} unexpected", capsys.readouterr().out)
    assert all(text in told[-1] for text in told)


@pytest.mark.nightly
def test_every_changed_law_gives_the_expected_result():
    assert [each.law.name for each in mutate() if not each.is_expected] == []
