"""No property test fails because the machine is busy."""

import ast
from pathlib import Path

from hypothesis import HealthCheck, settings

TESTS = Path(__file__).parent


def test_hypothesis_sets_no_deadline() -> None:
    profile = settings()
    assert profile.deadline is None and HealthCheck.too_slow in profile.suppress_health_check
    for path in TESTS.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "settings":
                given = {each.arg: ast.unparse(each.value) for each in node.keywords}
                assert given.get("deadline", "None") == "None", path
                # settings of a test replace those of the profile
                assert "HealthCheck.too_slow" in given.get("suppress_health_check", "HealthCheck.too_slow"), path
