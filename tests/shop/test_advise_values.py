"""Values that the adviser writes for the control; it replaces no file but its own."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from grind_env.errors import GrindError
from grind_env.shop.advise.adviser import Adviser, policy_for
from grind_env.shop.advise.file_kinds import LOG, STATE, VALUES
from grind_env.shop.advise.variables_file import check_variables, variables_of, write_values
from tests.command import Grind
from tests.shop.advising import PLATE, ROWS, batch, plate_in, session_of


def test_values_go_to_the_variables_that_each_block_reads(tmp_path: Path) -> None:
    simulation: Any = batch(PLATE, 2).simulation()
    adviser = Adviser(simulation, policy_for("E12000D1", simulation))
    assert adviser.advice is not None
    write_values(tmp_path / "O77.nc", simulation, [adviser.advice])
    lines = (tmp_path / "O77.nc").read_text().splitlines()
    assert lines == [
        "O77",
        "#101=12000. (E, MM/MIN, PART 1, BLOCK 1)",
        "#102=1 (D)",
        "#103=9000. (E, MM/MIN, AS PROGRAMMED)",
        "#104=0 (D)",
        "M99",
    ]
    assert variables_of(simulation.blocks[1], 1) == (103, 104)
    check_variables(simulation)

    def block(text: str) -> Any:
        plan = SimpleNamespace(code="G82")
        return SimpleNamespace(part=0, plan=plan, block=SimpleNamespace(source=SimpleNamespace(text=text, line=7)))

    assert variables_of(block("N50 g82 Y-.17 e#500 P9100 D # 7"), 3) == (500, 7)
    assert variables_of(block("N50 G82 Y-.17 E9000. P9100 D#7"), 3) == (107, 7)
    with pytest.raises(GrindError, match=r"line 7: E is an expression.* such as E#101"):
        variables_of(block("G82 Y-.17 E[#500*2]"), 0)
    shared: Any = SimpleNamespace(blocks=[block("E#101 D#102"), block("E#101")])
    with pytest.raises(GrindError, match="blocks 1 and 2 of one part both read #101"):
        check_variables(shared)


def test_values_may_be_written_to_a_called_program(grind: Grind, tmp_path: Path) -> None:
    program, values = plate_in(tmp_path), tmp_path / "O9050.nc"
    program.write_text(program.read_text().replace("M30", "M30\nO1\nM98 P9050\nM99", 1))
    words = ("advise", program, "--parts", 1, "--policy", "E12000D0", "--measurements", tmp_path / "m.csv")
    (tmp_path / "m.csv").write_text("mean_power\n2500\n")
    values.write_text("#101=12000.\nM99\n")
    assert grind(*words, "--write", values)[0] == 0
    assert values.read_text().startswith("O9050\n#101=12000. (E, MM/MIN, PART 1, BLOCK 1)\n")
    values.write_text("#101=12000.\nG04 P1.\nM99\n")
    status, _, err = grind(*words, "--write", values)
    assert status == 2 and "O9050.nc is read here and would be lost" in err


def test_variables_that_the_program_sets_or_uses_itself_are_refused(grind: Grind, tmp_path: Path) -> None:
    program = plate_in(tmp_path)
    text = program.read_text()
    words = ("advise", program, "--parts", 1, "--set", "#103=1", "--measurements", tmp_path / "m.csv")
    words = (*words, "--write", tmp_path / "v.nc")
    (tmp_path / "m.csv").write_text("mean_power\n")
    for line, message in (
        ("#102=5", "the program sets #102 itself, which would be written for D"),
        ("G04 X[0*#103+1]", "the program uses #103 itself, which would be written for E"),
    ):
        program.write_text(text.replace("N20 ", f"{line}\nN20 ", 1))
        status, _, err = grind(*words, "--restart")
        assert status == 2 and message in err.splitlines()[-1], err
    program.write_text(text.replace("E15000. P9100 D1", "E#101 P9100 D1").replace("N20 ", "#101=15000\nN20 ", 1))
    status, _, err = grind(*words, "--restart")
    assert status == 2 and "the program sets #101 itself" in err
    program.write_text(text.replace("N20 ", "(#102=5 IN A COMMENT)\nN20 ", 1))
    assert grind(*words, "--restart")[0] == 0


def test_the_adviser_replaces_no_file_but_its_own(grind: Grind, tmp_path: Path) -> None:
    program, measured = plate_in(tmp_path), tmp_path / "measured.csv"
    measured.write_text("mean_power,size_error\n2500,\n")
    words = ("advise", program, "--parts", 2, "--policy", "E12000D0", "--measurements", measured, "--state")
    for name in ("d.json", "d.csv", "values.nc"):
        (tmp_path / name).write_text("mine\n")
        for more in ((), ("--restart",)):
            written = ("--write", tmp_path / "values.nc") if name == "values.nc" else ()
            status, _, err = grind(*words, tmp_path / "d.json", *written, *more)
            assert status == 2 and f"{name}" in err and "is there already and would be lost" in err
            assert (tmp_path / name).read_text() == "mine\n"
        (tmp_path / name).unlink()
    (tmp_path / "values.nc").write_text("#101=12000. (as it was)\n#102=0\nM30\n")
    for more in ((), (), ("--restart",)):
        assert grind(*words, tmp_path / "d.json", "--write", tmp_path / "values.nc", *more)[0] == 0
        assert (tmp_path / "values.nc").read_text().startswith("#101=12000. (E, MM/MIN, PART 1, BLOCK 1)\n")
    assert {path.name for path in tmp_path.glob("*d.*")} == {"d.json", "d.csv", "measured.csv"}


def test_the_adviser_recognises_its_own_files(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        session_of(tmp_path, ROWS[:2], []).run()
    for name, own in (("state.json", STATE), ("state.csv", LOG), ("values.nc", VALUES)):
        assert own.fits(tmp_path / name) and own.fits(tmp_path / "none")
        for other in ("state.json", "state.csv", "values.nc"):
            assert own.fits(tmp_path / other) == (other == name)
    (tmp_path / "state.json").write_text((tmp_path / "state.json").read_text()[:-40])
    assert STATE.fits(tmp_path / "state.json")
    for name in (PLATE, PLATE.with_suffix(".toml")):
        assert not any(own.fits(name) for own in (STATE, LOG, VALUES))
