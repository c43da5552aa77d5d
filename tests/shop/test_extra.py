import subprocess
import sys
from pathlib import Path

import pytest

import grind_env
from tests.command import Grind
from tests.examples import few

PLATE = Path(grind_env.__file__).with_name("examples") / "plate_g82.nc"


def without(library: str, *words: object) -> subprocess.CompletedProcess[str]:
    """Runs a command where a library is not installed."""
    code = f"import sys; sys.modules[{library!r}] = None; from grind_env.cli import main; main(sys.argv[1:])"
    return subprocess.run([sys.executable, "-c", code, *map(str, words)], capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("library", "words", "said"),
    few(
        [
            ("scipy", ("calibrate", "log.csv", "--job", "plate.toml"), "a calibration needs SciPy"),
            ("jinja2", ("report", PLATE), "reports need Jinja2"),
            ("scipy", ("optimise", PLATE, "--parts", 2, "--budget", "1s"), "the search needs SciPy"),
            ("matplotlib", ("optimise", PLATE, "--budget", "60s", "--report", "r.html"), "reports need matplotlib"),
        ],
        2,
    ),
)
def test_one_sentence_names_the_extra_that_is_missing(library: str, words: tuple[object, ...], said: str) -> None:
    ended = without(library, *words)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr.strip() == f"grind: {said}: pip install '.[shop]' in the checkout of grind_env"


@pytest.mark.parametrize(
    "words",
    [
        ("optimise", PLATE, "-o", "none/a.nc"),
        ("optimise", PLATE, "--report", "none/a.html"),
        ("sweep", PLATE, "--plot", "none/a.png"),
        ("calibrate", "log.csv", "--job", "plate.toml", "-o", "none/a.toml"),
        ("calibrate", "log.csv", "--job", "plate.toml", "--report", "none/a.html"),
        ("report", PLATE, "-o", "none/a.html"),
    ],
)
def test_where_a_result_is_to_be_written_is_looked_at_before_the_work(
    words: tuple[object, ...], grind: Grind, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    status, out, err = grind(*words)
    assert (status, out) == (2, "")
    assert "there is no folder none; make it first" in err


def test_matplotlib_is_asked_for_before_the_sweep_that_it_draws() -> None:
    ended = without("matplotlib", "sweep", "none.nc", "--plot", "s.png")
    assert (ended.returncode, ended.stderr) == (
        2,
        "grind: plots need matplotlib: pip install '.[plot]' in the checkout of grind_env\n",
    )
