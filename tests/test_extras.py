"""What needs an extra says which, and how it is installed, in the same words everywhere."""

import re
import subprocess
import sys
from pathlib import Path

from grind_env.errors import GrindError
from grind_env.extras import LIBRARIES, MissingExtra

ROOT = Path(__file__).parents[1]
EXTRAS = re.findall(
    r"^(\w+) = \[",
    (ROOT / "pyproject.toml").read_text().partition("[project.optional-dependencies]")[2].partition("\n[")[0],
    re.MULTILINE,
)


def without(library: str, code: str) -> subprocess.CompletedProcess[str]:
    lines = f"import sys; sys.modules[{library!r}] = None; {code}"
    return subprocess.run([sys.executable, "-c", lines], capture_output=True, text=True, check=False)


def said(name: str, what: str = "grind_env.sb3", extra: str = "sb3") -> str:
    return f"{what} needs {name}: pip install '.[{extra}]' in the checkout of grind_env"


def test_the_adapter_names_its_extra() -> None:
    ended = without("stable_baselines3", "import grind_env.sb3")
    assert ended.stderr.splitlines()[-1] == f"grind_env.extras.MissingExtra: {said('Stable-Baselines3')}"
    assert issubclass(MissingExtra, GrindError) and issubclass(MissingExtra, ImportError)


def test_so_does_the_command_that_trains_before_it_reads_anything() -> None:
    ended = without("torch", "from grind_env.cli import main; main(['train', 'nothing.nc'])")
    message = said("PyTorch", "grind train", "train")
    assert (ended.returncode, ended.stdout, ended.stderr) == (2, "", f"grind: {message}\n")


def test_extras_are_spelt_in_one_way() -> None:
    """In code, pages and notebooks: as a checkout installs them, for the package is in no index."""
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
