"""Laws are changed one at a time, and what notices them is counted."""

import os
import subprocess
import sys

import pytest

from grind_env.errors import GrindError
from grind_env.validation import CHECKS
from grind_env.validation import __main__ as module
from grind_env.validation.mutations import LAWS, LEAST, Law, Noticed, mutate

ONE_ROW = """
from grind_env.process.catalogue import load_catalogue
from grind_env.validation import CHECKS, Rig, row_of
from grind_env.validation.mutations import LAWS, changed
law = next(law for law in LAWS if law.name == "severity goes with the root of the dress depth")
check = next(check for check in CHECKS if check.name == "flats by depth")
rig = Rig(load_catalogue())
with changed(law):
    inside = row_of(check, rig).value
print(inside, row_of(check, rig).value)
"""


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_a_law_stands_once_in_its_function_and_its_change_compiles(law):
    compile(law.source(), law.function, "exec")
    assert not law.known or law.decides


def test_laws_have_names_of_their_own():
    assert len({law.name for law in LAWS}) == len(LAWS)


def test_a_text_that_does_not_stand_there_is_refused():
    with pytest.raises(GrindError, match=r"laws.csv: other: equations.dressing.severity has 'colour' 0 times"):
        Law("other", "equations.dressing.severity", "colour", "grey").source()


def test_a_change_holds_for_a_while():
    done = subprocess.run(
        [sys.executable, "-c", ONE_ROW],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    # flats of .25 + .75 s^(-1/2), of a quarter of the severity and, with its root in the depth, of half of it
    assert list(map(float, done.stdout.split())) == pytest.approx([0.25 + 0.75 * 2**0.5, 1.75])


@pytest.mark.parametrize(
    ("law", "rows", "status"),
    [
        (Law("of nothing", "", "", ""), (), 0),
        (Law("of a decision", "", "", "", "dress interval"), ("one",), 1),
        (Law("of a decision", "", "", "", "dress interval"), ("one", "two"), 0),
        (Law("known", "", "", "", "dress interval", "nobody has measured it"), ("one",), 0),
        (Law("known", "", "", "", "dress interval", "nobody has measured it"), ("one", "two"), 1),
    ],
)
def test_the_exit_status_says_whether_decisions_are_noticed(law, rows, status, monkeypatch, capsys):
    monkeypatch.setattr(module, "mutate", lambda: [Noticed(law, rows)])
    assert module.main(["--mutate"]) == status
    said = capsys.readouterr().out
    assert law.name in said and law.known in said and "; ".join(rows) in said
    assert f"1 laws, of which {int(not law.decides)} carry no decision: {int(len(rows) >= LEAST)}" in said


@pytest.mark.nightly
def test_every_decision_is_noticed():
    found = mutate()
    assert [each.law.name for each in found if not each.as_known] == []
    assert {name for each in found for name in each.rows} <= {check.name for check in CHECKS}
