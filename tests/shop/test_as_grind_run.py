"""The "grind run" column of `optimise` agrees with `grind run`, for stages and for parts unloaded within a cycle."""

import json
from pathlib import Path

import numpy as np
import pytest

from grind_env.control import read
from grind_env.machine.grind import grind
from grind_env.machine.job.job_file import load_job
from grind_env.shop.optimise.judgement import QUANTITIES
from grind_env.shop.optimise.tables import NAMES
from grind_env.shop.trials import trials_of
from tests.command import Grind
from tests.examples import nightly

HEAD = "G71 G94 G90 G19\nG00 Y2. Z-2.5\nG00 X-30.\nG01 Y0 F500.\n"
END = "G80\nG00 Y20.\nM30\n"
FINISH = "G82 Y-.1 J-.002 L4 F60. E9000.\n"
REPLAYED = f"{HEAD}G82 X230. I-30. Y-.06 J-.02 F60. E20000.\nM01\n{FINISH}{END}"
EXECUTED = REPLAYED.replace("Y-.06", "Y-.08")  # the table moves at M01
INSIDE = (
    f"{HEAD}G01 Y-.04 F500.\nG81 X230. I-30. E30000.\nG04 X4.1\nM01\nG04 X.3\nM00\n"
    f"G82 Y-.06 J-.005 L4 F60. E9000.\n{END}"
)
STAGE = "[[part.stages]]\nstock = 0.06\nrise_allowance = 300\nroughness_limit = 0.6\n"
#: column of `grind run --json` for each quantity of `optimise --json`, and the factor between their units
RUN = {
    "cost": ("total_cost", 1.0),
    "seconds": ("seconds", 1.0),
    "Ra": ("Ra", 1.0),
    "power": ("peak_power", 0.001),
    "rise": ("rise", 1.0),
    "highest_rise": ("highest_rise", 1.0),
    "size_error": ("worst_error", 1.0),
    "scrap": ("survival", 100.0),
}


def job_text(*stages: str) -> str:
    part = 'material = "aisi_52100"\nlength = 200\nwidth = 20\nstock = 0.1\nroughness_limit = 0.8\nscrap_cost = 40\n'
    return "\n".join(["[part]", part, *stages, '[setup]\nspindle = "always on"\ncoolant = "always on"\n'])


@pytest.mark.usefixtures("few_lots")
@pytest.mark.usefixtures("coarse_speeds")
@pytest.mark.parametrize(
    ("text", "stages"),
    [(REPLAYED, [STAGE]), nightly(EXECUTED, [STAGE]), nightly(INSIDE, [])],
    ids=["replayed stages", "executed stages", "M00 in a cycle"],
)
def test_every_quantity_of_optimise_agrees_with_grind_run(
    text: str, stages: list[str], tmp_path: Path, grind: Grind
) -> None:
    path = tmp_path / "part.nc"
    path.write_text(text)
    path.with_suffix(".toml").write_text(job_text(*stages))
    options = ["--vary", "E", "--bounds", "E=8000..30000", "--parts", 1, "--budget", "1000s", "--untried"]
    found = json.loads(grind("optimise", path, *options, "--json")[1])
    assert {each["name"] for each in found["quantities"]} == {*RUN} == {*QUANTITIES} == {*NAMES}
    for which, program in enumerate((text, found["text"])):
        path.write_text(program)
        parts = json.loads(grind("run", path, "--json")[1])["parts"]
        for each in found["quantities"]:
            column, share = RUN[each["name"]]
            values = np.abs([part[column] for part in parts])
            shown = share * float(np.mean(1.0 - values if each["name"] == "scrap" else values))
            assert each["expected"][which] == pytest.approx(shown, rel=1e-9, abs=1e-9), (each["name"], which)


def test_run_shows_the_highest_temperature_if_the_last_stage_is_cooler(tmp_path: Path, grind: Grind) -> None:
    path = tmp_path / "part.nc"
    path.write_text(REPLAYED)
    for stages in ([STAGE], []):
        path.with_suffix(".toml").write_text(job_text(*stages))
        (part,) = json.loads(grind("run", path, "--json")[1])["parts"]
        assert (part["highest_rise"] > part["rise"] + 200.0) == bool(stages)
        rows = grind("run", path)[1].splitlines()
        assert ("highest" in rows[1]) == bool(stages) and f"{part['highest_rise']:.0f}" in rows[4].split()
        assert (f"{part['rise']:.0f}" in rows[4].split()) and ("last st." in rows[1]) == bool(stages)


@pytest.mark.parametrize("text", [REPLAYED, EXECUTED])
def test_each_stage_is_measured_by_its_own_limits(text: str, tmp_path: Path) -> None:
    path = tmp_path / "part.toml"
    path.write_text(job_text(STAGE))
    job = load_job(path)
    strokes = grind(read(text), job).strokes
    first, last = (strokes[strokes["line"] == line] for line in np.unique(strokes["line"]))
    trials = trials_of(read(text), job, 1, [(0,)], spread=0.0)
    found = trials.measure(trials.own[None])
    rise, most = first["T"].max(), job.limits.rise
    assert found.ratios[0, 1] == pytest.approx(max(rise / (most + 300.0), last["T"].max() / most), rel=1e-6)
    assert np.isclose(first["Ra"] / 0.6, found.ratios[0, 2], rtol=1e-6).any()  # a stroke may end after M01
