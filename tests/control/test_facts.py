"""Every statement of the manual and every decision is listed, with an existing test."""

import ast
import functools
import json
from collections import Counter
from pathlib import Path

import pytest

from grind_env.control.facts import MARKS, load_facts
from tests.command import Grind

ROOT = Path(__file__).parents[2]
FACTS = load_facts()

# Counts from the pages and the decision tables of the reference files, not from facts.toml.
ROWS = {
    **{"16-13.": 28, "22-11.": 17, "15-20.": 12, "L23-7.": 27},
    **{"PD-": 24, "ruling-": 13},
    **{"grammar-D": 19, "paramacro-D": 18, "dressing-D": 22},
    **{"grooving-D": 18, "compensation-D": 18},
}
PAGES = """
10-6 10-7 10-23 11-10 12-41 12-53 12-54 12-55 12-56 12-60 15-2 15-5 15-11 15-12 15-17 15-19 15-20 15-26 15-27 15-37
15-38 15-45 15-59 16-9 16-13 16-16 18-4 20-2 20-13 22-11 AMP23-5 L10-15 L10-17 L11-8 L14-4 L14-5 L14-10 L21-5 L21-17
L21-23 L21-24 L21-35 L21-39 L21-45 L21-49 L21-54 L22-2 L23-3 L23-4 L23-7 L29-6 L29-7 M21-5 M21-7 M21-16 M21-18 M21-25
M21-26 M21-40 M21-42 M21-51 M29-7
"""


@functools.cache
def functions(file: str) -> frozenset[str]:
    tree = ast.parse((ROOT / file).read_text())
    return frozenset(node.name for node in tree.body if isinstance(node, ast.FunctionDef))


def test_a_fact_has_a_test_or_a_reason() -> None:
    for fact in FACTS:
        assert bool(fact.tests) != bool(fact.outside), fact.id
        for name in fact.tests:
            file, _, function = name.partition("::")
            assert function.startswith("test_") and function in functions(file), name


def test_a_fact_is_a_sentence_with_a_source() -> None:
    for fact in FACTS:
        assert fact.mark in MARKS, fact.id
        assert fact.text.endswith(".") and fact.text[0].isupper(), fact.id
        assert fact.page or fact.mark == "decided", fact.id
        if fact.mark != "decided":
            source, _, number = fact.id.rpartition(".")
            assert source == fact.page.replace(" ", "") and number.isdigit(), fact.id


def test_no_id_occurs_twice() -> None:
    assert [name for name, count in Counter(fact.id for fact in FACTS).items() if count > 1] == []


@pytest.mark.parametrize(("prefix", "count"), ROWS.items())
def test_no_row_is_missing(prefix: str, count: int) -> None:
    ids = {fact.id for fact in FACTS if fact.id.startswith(prefix)}
    assert ids == {f"{prefix}{number}" for number in range(1, count + 1)}


def test_no_page_is_missing() -> None:
    assert set(PAGES.split()) <= {fact.page.replace(" ", "") for fact in FACTS}


def test_less_than_8_percent_of_the_facts_have_no_test() -> None:
    outside = [fact.id for fact in FACTS if fact.outside]
    assert len(outside) < 0.08 * len(FACTS)


def test_grind_facts_prints_a_table(grind: Grind) -> None:
    status, out, _ = grind("facts", "--page", "10-23", "--mark", "seen")
    assert status == 0
    assert "10-23.1" in out and "G[#12+6]" in out and "22-11" not in out


def test_grind_facts_prints_json(grind: Grind) -> None:
    _, out, _ = grind("facts", "--mark", "decided", "--json")
    found = json.loads(out)
    assert [one["id"] for one in found] == [fact.id for fact in FACTS if fact.mark == "decided"]
    assert set(found[0]) == {"id", "text", "page", "mark", "tests", "outside"}


@pytest.mark.parametrize(
    ("options", "words"),
    [(("--mark", "guessed"), "marks are seen, inferred, decided"), (("--page", "99-1"), "pages are ")],
)
def test_an_unknown_mark_or_page_is_refused(options: tuple[str, ...], words: str, grind: Grind) -> None:
    status, _, err = grind("facts", *options)
    assert status == 2 and words in err


def test_a_narrow_table_does_not_wrap_the_names_of_tests(grind: Grind, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    _, out, _ = grind("facts", "--page", "16-13")
    lines = [line.strip() for line in out.splitlines()]
    chosen = [fact for fact in FACTS if fact.page == "16-13"]
    assert chosen and all(test in lines for fact in chosen for test in fact.tests)
