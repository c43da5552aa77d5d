"""The mutations still match the code of the package."""

import ast

import pytest

from grind_env.errors import GrindError
from grind_env.toml import read_toml
from tests.mutations.__main__ import FILES, ROOT, Mutation

MUTATIONS = [Mutation(**each) for file in FILES for each in read_toml(file)["mutation"]]


def test_every_mutation_changes_a_line_that_occurs_once_and_its_tests_exist() -> None:
    for each in MUTATIONS:
        text = (ROOT / each.file).read_text(encoding="utf-8")
        assert ast.dump(ast.parse(each.applied(text))) != ast.dump(ast.parse(text)), each.name
        assert each.tests and all((ROOT / test).exists() for test in each.tests), each.name
    assert len({each.name for each in MUTATIONS}) == len(MUTATIONS)


@pytest.mark.parametrize(("text", "count"), [("left = 5\n", 0), ("left = 4\nleft = 4\n", 2)])
def test_a_mutation_refuses_a_line_that_does_not_occur_exactly_once(text: str, count: int) -> None:
    mutation = Mutation("fewer", "a.py", "left = 4", "left = 3", "one less", ["tests"])
    assert mutation.applied("    left = 4\n") == "    left = 3\n"
    with pytest.raises(GrindError, match=rf"fewer: a\.py has 'left = 4' {count} times"):
        mutation.applied(text)
