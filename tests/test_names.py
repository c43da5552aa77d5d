"""One name stands for one thing: no two classes of the package and of `agents` share a name."""

import ast
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
#: names still shared: one of the two classes is in compiled code, where a new name recompiles all kernels
SHARED = {"Block", "Entry", "Fixed", "Infeed", "Place", "Signals"}


def test_no_two_classes_share_a_name() -> None:
    files = [path for folder in ("grind_env", "agents") for path in (ROOT / folder).rglob("*.py")]
    nodes = (node for path in files for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    count = Counter(node.name for node in nodes if isinstance(node, ast.ClassDef))
    assert {name for name, number in count.items() if number > 1} == SHARED
