"""Rules for every notebook, checked without running it: `make notebooks` runs them."""

import ast
import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "docs" / "tools"))
from shown import MOST, compare, keep

NOTEBOOKS = sorted((Path(__file__).parents[1] / "notebooks").glob("*.ipynb"))


def cells(path: Path, kind: str) -> list[str]:
    found: list[dict[str, Any]] = json.loads(path.read_text("utf-8"))["cells"]
    return ["".join(cell["source"]) for cell in found if cell["cell_type"] == kind]


def test_there_are_eight_notebooks_numbered_from_1():
    assert [path.name[:3] for path in NOTEBOOKS] == [f"{number:02d}_" for number in range(1, 9)]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_has_a_title_a_question_a_conclusion_and_two_exercises(path):
    first = json.loads(path.read_text("utf-8"))["cells"][0]
    assert first["cell_type"] == "markdown" and "".join(first["source"]).startswith("# ")
    text = "\n\n".join(cells(path, "markdown"))
    assert len(re.findall(r"^# ", text, re.MULTILINE)) == 1
    assert "**Question.**" in "".join(first["source"])
    assert re.findall(r"^## (Conclusion|Exercises)$", text, re.MULTILINE) == ["Conclusion", "Exercises"]
    exercises = text.partition("## Exercises")[2]
    assert re.findall(r"^(\d)\. ", exercises, re.MULTILINE) == ["1", "2"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_needs_only_the_installed_package(path):
    """It is plain Python and needs no checkout, so that any kernel runs it."""
    for code in cells(path, "code"):
        for node in ast.walk(ast.parse(code)):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [each.name for each in node.names] if isinstance(node, ast.Import) else []
            assert not {name.partition(".")[0] for name in names} & {"agents", "tests", "sys", "os"}, code
            assert not (isinstance(node, ast.Name) and node.id == "__file__"), code
            assert not (isinstance(node, ast.Attribute) and node.attr == "__file__"), code


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_slider_varies_a_function_of_an_earlier_cell(path):
    """The cell of a slider is skipped in execution: nbclient may wait for its output for ever."""
    before: dict[str, list[str]] = {}
    called: set[str] = set()
    knobs = 0
    for cell in json.loads(path.read_text("utf-8"))["cells"]:
        if cell["cell_type"] != "code":
            continue
        code = ast.parse("".join(cell["source"]))
        calls = [node for node in ast.walk(code) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)]
        turned = [call for call in calls if call.func.id == "interact"]
        assert bool(turned) == ("skip-execution" in cell["metadata"].get("tags", []))
        for call in turned:
            drawn = call.args[0].id
            assert {word.arg for word in call.keywords} <= set(before[drawn]) and drawn in called
            knobs += 1
        called |= {call.func.id for call in calls}
        functions = [node for node in code.body if isinstance(node, ast.FunctionDef)]
        before |= {function.name: [each.arg for each in function.args.args] for function in functions}
    assert knobs


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_holds_the_outputs_of_one_run_without_errors(path):
    text = path.read_text("utf-8")
    assert len(text.encode()) <= MOST
    run = [
        cell
        for cell in json.loads(text)["cells"]
        if cell["cell_type"] == "code" and "skip-execution" not in cell["metadata"].get("tags", [])
    ]
    assert [cell["execution_count"] for cell in run] == [*range(1, len(run) + 1)]
    outputs = [output for cell in run for output in cell["outputs"]]
    assert sum("image/png" in output.get("data", {}) for output in outputs) >= 2
    assert not [output for output in outputs if output["output_type"] == "error" or output.get("name") == "stderr"]


def notebook(text: str, *, tags: tuple[str, ...] = (), picture: str = "") -> dict[str, Any]:
    """Return an executed notebook that printed a text."""
    outputs = [
        {"output_type": "stream", "name": "stderr", "text": ["compiling, about 20 s\n"]},
        {"output_type": "stream", "name": "stdout", "text": [text]},
    ]
    if picture:
        data = {"image/png": picture, "text/plain": ["<Figure size 9x3>"]}
        outputs.append({"output_type": "display_data", "data": data, "metadata": {}})
    cell = {"cell_type": "code", "execution_count": 7, "metadata": {"tags": [*tags]}, "outputs": outputs, "source": []}
    return {"cells": [cell]}


def test_changed_output_is_reported_unless_its_cell_varies(tmp_path):
    kept, executed = tmp_path / "kept.ipynb", tmp_path / "executed.ipynb"
    executed.write_text(json.dumps(notebook("2.46 $\n")))
    assert keep(executed, kept) == "" == compare(executed, kept)
    assert "compiling" not in kept.read_text()
    executed.write_text(json.dumps(notebook("2.47 $\n")))
    assert compare(executed, kept) == "cell 0 shows\n2.47 $\n\ninstead of\n2.46 $\n"
    executed.write_text(json.dumps(notebook("in 3 s\n", tags=("varies",))))
    keep(executed, kept)
    executed.write_text(json.dumps(notebook("in 5 s\n", tags=("varies",))))
    assert compare(executed, kept) == ""
