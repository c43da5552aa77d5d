"""Nothing here is judged by the clock of a machine that may be busy."""

import ast
from pathlib import Path

from hypothesis import HealthCheck, settings

TESTS = Path(__file__).parent


def test_no_property_is_timed_by_hypothesis() -> None:
    profile = settings()
    assert profile.deadline is None and HealthCheck.too_slow in profile.suppress_health_check
    for path in TESTS.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "settings":
                given = {each.arg: ast.unparse(each.value) for each in node.keywords}
                assert given.get("deadline", "None") == "None", path
                # what a test names replaces what the profile names
                assert "HealthCheck.too_slow" in given.get("suppress_health_check", "HealthCheck.too_slow"), path
