"""A feature that needs an extra names it and its installation, in the same words everywhere."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from grind_env import examples
from grind_env.errors import GrindError
from grind_env.optional_libraries import LIBRARIES, MissingExtra
from tests.examples import few

ROOT = Path(__file__).parents[1]
PLATE = str(examples.path("plate_g82.nc"))
EXTRAS = re.findall(
    r"^(\w+) = \[",
    (ROOT / "pyproject.toml").read_text().partition("[project.optional-dependencies]")[2].partition("\n[")[0],
    re.MULTILINE,
)


def without(library: str, code: str, *words: str) -> subprocess.CompletedProcess[str]:
    lines = f"import sys; sys.modules[{library!r}] = None; {code}"
    return subprocess.run([sys.executable, "-c", lines, *words], capture_output=True, text=True, check=False)


def remedy(extra: str) -> str:
    return f"pip install '.[{extra}]' in the checkout of grind_env\n"


def test_the_adapter_names_its_extra() -> None:
    ended = without("stable_baselines3", "import grind_env.sb3")
    said = f"grind_env.optional_libraries.MissingExtra: grind_env.sb3 needs Stable-Baselines3: {remedy('sb3')}"
    assert ended.stderr.endswith(f"\n{said}")
    assert issubclass(MissingExtra, GrindError) and issubclass(MissingExtra, ImportError)


@pytest.mark.parametrize(
    ("library", "words", "said", "extra"),
    few(
        [
            ("torch", ("train", "nothing.nc"), "grind train needs PyTorch", "train"),
            ("scipy", ("calibrate", "log.csv", "--job", "plate.toml"), "a calibration needs SciPy", "shop"),
            ("matplotlib", ("sweep", "none.nc", "--plot", "s.png"), "plots need matplotlib", "plot"),
            ("jinja2", ("report", PLATE), "reports need Jinja2", "shop"),
            ("scipy", ("optimise", PLATE, "--parts", "2", "--budget", "1s"), "the search needs SciPy", "shop"),
            ("matplotlib", ("optimise", PLATE, "--report", "r.html"), "reports need matplotlib", "shop"),
        ],
        4,
    ),
)
def test_a_command_names_a_missing_extra_before_any_work(
    library: str, words: tuple[str, ...], said: str, extra: str
) -> None:
    ended = without(library, "from grind_env.cli import main; main(sys.argv[1:])", *words)
    assert (ended.returncode, ended.stdout, ended.stderr) == (2, "", f"grind: {said}: {remedy(extra)}")


def test_extras_are_spelt_in_one_way() -> None:
    named = set()
    for path in subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split():
        if not path.endswith((".py", ".md", ".ipynb", ".toml")) or path in ("CHANGELOG.md", "pyproject.toml"):
            continue
        text = (ROOT / path).read_text(encoding="utf-8")
        assert not re.search(r"(?:install|pip \w+) '?grind_env\[", text), path
        named |= {
            extra for each in re.findall(r"'\.\[([\w,]+)\]'", text) for extra in each.split(",") if "test" not in path
        }
    assert {"shop", "sb3", "plot", "notebooks", "agents"} <= named <= set(EXTRAS)
    assert len(LIBRARIES) > 5
