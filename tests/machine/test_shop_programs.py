"""Programs as shops write them, in odd layouts: checked, ground, and replayed to the same numbers."""

import json
from pathlib import Path
from typing import Any

import pytest

from grind_env.control import Programs, check, read, read_file
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.machine.grind import grind
from grind_env.machine.job import Job
from grind_env.machine.script.script import script_of
from grind_env.machine.script.script_block import ScriptError
from tests.command import status
from tests.machine.harness import DRESS, HEAD, machine_after
from tests.machine.test_replay import assert_replayed, shop

DRESS_INCH = """
O9100 (DRESSING, INCHES)
G70 G90 G94
G00 Y.8
X-4.7 Z-1.6
Y.4
G91 G01 Y-.0008 F2.4
Z1.4 F7.5
Y-.0008 F2.4
Z-1.4 F7.5
G90 G00 Y.8
M99
"""

#: programs for a part that the wheel covers
NARROW = {
    "small letters, no blanks, CRLF": (
        "%\r\no0815(rail)\r\ng71g94g90g19\r\ng0y20.\r\ng0x-30.z-2.5\r\ng1y0f500.\r\n"
        "g82x230.i-30.y-.03j-.01l2f60.e12000.p9100d1\r\ng80\r\ng0y20.\r\nm30\r\n"
        + DRESS.replace("\n", "\r\n")
        + "%\r\n"
    ).encode(),
    "tabs, remarks behind semicolons, Latin-1": (
        "%\nO1\t(Führungsleiste für Böhm)\n\n; 100% of the stock, A. Müller\nN10\tG71\tG94 G90\tG19 ; metric\n"
        "/N15 M01 ; gauge the blank\nN20 G00 Y20.;N30 G00 X-30.\tZ-2.5\nN40 G01 Y0 F500. ; touch\n"
        "N50\tG82 X230. I-30. Y-.02\tJ-.005 L1 F60. E9000. P9100 ; -- finish --\nN60 G80;N70 G00 Y20.;M30\n" + DRESS
    ).encode("latin-1"),
    "parts by WHILE, E and L from variables": (
        "O7\nG71G94G90G19\n#101=12000.\n#1=1\nWHILE[#1LE3]DO1\nG0Y20.\nG0X-30.Z-2.5\nG1Y0F500.\n"
        "G82X230.I-30.Y-.03J-.01L#1F60.E[#101-#1*500]P9100D[#1 MOD 2]\nG80\nG0Y20.\nM00\n#1=#1+1\nEND1\nM30\n" + DRESS
    ).encode(),
    "parts by M98 L, roughing and finishing inside": (
        "O1\nG71 G94 G90 G19\nM98 P20 L3\nM30\nO20\nG00 Y20.\nG00 X-30. Z-2.5\nG01 Y0 F500.\n"
        "G82 X230. I-30. Y-.04 J-.02 L0 F60. E15000. P9100 D1\nG80\nM01\nG00 X-30.\n"
        "G82 Y-.05 J-.005 L3 F60. E9000.\nG80\nG00 Y20.\nM00\nM99\n" + DRESS
    ).encode(),
    "parts by GOTO": (
        "N5 G71 G94 G90 G19\n#500=0\nN10 #500=#500+1\nG00 Y20.\nG00 X-30. Z-2.5\nG01 Y.01 F500.\n"
        "G82.1 X230. I-30. Y-.02 J-.01 Q0 L1 F60. E10000. P9100\nG80\nG00 Y20.\nIF [#500 GE 2] GOTO 99\nM00\nGOTO 10\n"
        "N99 M30\n" + DRESS
    ).encode(),
    "a macro with arguments for every cycle": (
        "G71 G94 G90 G19\nG00 Y20.\nG00 X-30. Z-2.5\nG01 Y0 F500.\n"
        "G65 P8000 A.03 J.01 E15000 L1\nM01\nG00 X-30.\nG65 P8000 A.04 J.004 E8000 S2\nG00 Y20.\nM30\n"
        "O8000 (A DEPTH, J PICK, E SPEED, S SPARK-OUT)\nIF [#19 EQ #0] THEN #19=0\n"
        "IF [#1 LE 0] THEN #3000=1 (NO DEPTH)\n"
        "G82 X230. I-30. Y-#1 J-#5 L#19 F60. E#8 P9100\nG80\n#19=#0\nM99\n" + DRESS
    ).encode(),
    "depths by a loop within the part": (
        "G71 G94 G90 G19\nG00 Y20.\nG00 X-30. Z-2.5\nG01 Y0 F500.\n#2=0\nWHILE [#2 LT .05] DO 2\n#2=#2+.02\n"
        "IF [#2 GT .05] THEN #2=.05\nG82 X230. I-30. Y[-#2] J-[ROUND[1000*SQRT[.0001]]/1000] L0 F60. E14000. P9100\n"
        "G80\nG00 X-30.\nEND 2\nG00 Y20.\nM30\n" + DRESS
    ).encode(),
    "inches": (
        "O2 (INCH)\nG70 G94 G90 G19\n#1=0\nWHILE [#1 LT 2] DO 1\nG00 Y.8\nG00 X-1.2 Z-.1\nG01 Y0 F20.\n"
        "G82 X9. I-1.2 Y-.0012 J-.0004 L1 F2.4 E[480.+#1*20] P9100 D1\nG80\nG00 Y.8\nM00\n#1=#1+1\nEND 1\nM30\n"
        + DRESS_INCH
    ).encode(),
    "G81 with an infeed of its own": (
        "G71 G94 G90 G19\nG00 Y20.\nG00 X-30. Z-2.5\nG01 Y0 F500.\nG81 X230. I-30. E10000. P9100\n"
        "#4=0\nWHILE [#4 LT 3] DO 3\n#4=#4+1\nG01 Y[-.01*#4] F.4\nG04 P.5\nEND 3\nG80\nG00 Y20.\nM30\n" + DRESS
    ).encode(),
    "a dress program with variables": (
        b"G71 G94 G90 G19\n#105=191.\n#106=2\n#1=1\nWHILE [#1 LE 2] DO 1\nG00 Y20.\nG00 X-30. Z-2.5\nG01 Y0 F500.\n"
        b"G82 X230. I-30. Y-.03 J-.01 L1 F60. E12000. P9200 D2\nG80\nG00 Y20.\nM00\n"
        b"#105=120.\n#106=4\n#1=#1+1\nEND 1\nM30\n"
        b"O9200\nG71 G90 G94\nG00 Y20.\nG00 X-120. Z-40.\nG00 Y10.\nG91\n#30=0\n#31=1\nWHILE [#30 LT #106] DO 3\n"
        b"G01 Y-.02 F60.\nZ[35*#31] F#105\n#31=-#31\n#30=#30+1\nEND 3\nG90 G00 Y20.\nM99\n"
    ),
    "shifted origins and machine coordinates": (
        "G71 G94 G90 G19\nG53 G00 Y20.\nG52 X-5. Y.01\nG00 X-25. Z-2.5\nG01 Y-.01 F500.\n"
        "G82 X235. I-25. Y-.04 J-.01 L1 F60. E12000. P9100\nG80\nG52 X0 Y0\nG53 G00 Y20.\nM30\n" + DRESS
    ).encode(),
    "depth from where the wheel stands": (
        "G71 G94 G90 G19\nG00 Y20.\nG00 X-30. Z-2.5\nG01 Y0 F500.\n#1=#5042\n"
        "G82 X230. I-30. Y[#1-.03] J-.01 L1 F60. E12000. P9100\nG80\nG00 Y[#5002+20]\nM30\n" + DRESS
    ).encode(),
    "modal words and an early end": (
        b"%\nO99999 (X)\n(HEAD)\n\nG71 G94 G90 G19 M08 S1910 M03\nG00 Y20. Z-2.5\nX-30.\nG01 Y0 F500.\n"
        b"G82 X230. I-30. Y-.02 J-.01 L0 F60. E15000.\nG82 Y-.03 J-.005\n"
        b"G82 E8000. L2\nG80 M05 M09\nG00 Y20.\nM30\n%\nG00 X-\n"
    ),
}

WIDE = {
    "G83 in a loop, inches": (
        "G70 G94 G90 G19\n#1=0\nWHILE[#1LT2]DO1\nG00 Y.8\nG00 X-1.2 Z0\nG01 Y0 F20.\n"
        "G83 X9. I-1.2 Y-.0012 J-.0006 Z.6 K.3 L1 F60. E[450.+10*#1] P9100\nG80\nG00 Y.8\nM00\n#1=#1+1\nEND1\nM30\n"
        + DRESS_INCH
    ).encode(),
    "G83 by a macro in a subprogram": (
        "o1;g71g94g90g19;m98p5l2;m30\no5\ng0y20.\ng0x-30.z0\ng1y0f500.\ng65p6a.02z15.\ng0y20.\nm0\nm99\n"
        "o6\ng83x230.i-30.y[-#1]j-.01z#26k[#26/2]r5.l0f1500.e9000.p9100d1\ng80\nm99\n" + DRESS
    ).encode(),
}


@pytest.fixture(params=[*NARROW, *WIDE])
def case(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Programs, Job]:
    path = tmp_path / "part.nc"
    path.write_bytes({**NARROW, **WIDE}[request.param])
    return read_file(path), shop(**{"width": 40.0} if request.param in WIDE else {})


def test_a_shop_program_is_checked_and_ground(case: tuple[Programs, Job]) -> None:
    programs, job = case
    report = check(programs, job.control)
    assert report.errors == [] and report.motions > 0
    record = grind(programs, job)
    assert len(record.parts) >= 1 and (record.parts["survival"] > 0.0).any()


def test_the_replay_of_a_shop_program_equals_the_control(case: tuple[Programs, Job]) -> None:
    programs, job = case
    simulation = JobSimulation(programs, job, 0.0)
    assert simulation.why is None
    plans = [block.plan for block in simulation.blocks]
    replayed = assert_replayed(simulation, [(plan.feed, plan.dresses) for plan in plans], machine_after(programs, job))
    whole = grind(programs, job)
    assert replayed.parts["total_cost"].tolist() == pytest.approx(whole.parts["total_cost"].tolist(), rel=1e-9)


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ("IF [#2033 LT 150] THEN #1=1", "reads #2033, which depends on the wheel"),
        ("#1=#5041", "reads #5041, which depends on the wheel, on its dresses or on where a cycle has ended"),
    ],
)
def test_a_program_that_reads_the_state_of_the_run_has_no_script(tmp_path: Path, lines: str, reason: str) -> None:
    path = tmp_path / "part.nc"
    text = NARROW["modal words and an early end"].decode()
    path.write_text(text.replace("G82 E8000.", f"{lines}\nG82 E8000."), encoding="utf-8")
    programs, job = read_file(path), shop()
    with pytest.raises(ScriptError, match=reason):
        script_of(programs, job)
    assert len(grind(programs, job).parts) == 1


@pytest.mark.parametrize("line", ["#5222=[#5222-.01]", "G10 L2 P1 Y-.01", "M09", "T2"])
def test_a_dress_that_changes_offsets_tool_or_coolant_has_no_script(line: str) -> None:
    text = f"{HEAD}M08\nG82 X230. I-30. Y-.03 J-.01 F600. E9000. P9100 D1\nG80\nM30\n{DRESS}"
    script_of(read(text), shop())
    changed = text.replace("M99", f"{line}\nM99")
    with pytest.raises(ScriptError, match="dress program O9100 leaves offsets, tables, wheel or coolant otherwise"):
        script_of(read(changed), shop())


def test_a_script_takes_variables_from_outside(tmp_path: Path) -> None:
    path = tmp_path / "part.nc"
    path.write_bytes(NARROW["parts by WHILE, E and L from variables"].replace(b"#101=12000.\n", b""))
    script = script_of(read_file(path), shop(), variables={101: 9000.0})
    assert [block.plan.feed for block in script.blocks] == [8500.0, 8000.0, 7500.0]


PLATE = Path(__file__).parents[2] / "grind_env" / "examples" / "plate_g82.nc"


def ran(capsys: pytest.CaptureFixture[str], *options: str) -> dict[str, Any]:
    ended = status("run", *options, "--json")
    out, err = capsys.readouterr()
    assert ended in (0, 1), err
    found: dict[str, Any] = json.loads(out)
    return found


def test_grind_run_takes_requests_and_variables(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    plate, job = tmp_path / "plate.nc", str(PLATE.with_suffix(".toml"))
    text = PLATE.read_text(encoding="utf-8").replace("E9000.", "E#101")
    plate.write_text(text.replace("O9100 (", "O9300\nG91 G00 Y5.\nG04 P60.\nM99\nO9100 (", 1), encoding="utf-8")
    options = (str(plate), "--job", job, "--set", "#101=9000")
    plain = ran(capsys, *options)
    dressed = ran(capsys, *options, "--dress-at", "30")
    interrupted = ran(capsys, *options, "--interrupt", "9300@30")
    assert plain["parts"] == ran(capsys, str(PLATE), "--job", job)["parts"]
    assert dressed["parts"][0]["dresses"] == plain["parts"][0]["dresses"] + 1
    longer = interrupted["parts"][0]["seconds"] - plain["parts"][0]["seconds"]
    assert 60.0 < longer < 62.0


def test_the_warning_of_an_excessive_speed_suggests_the_other_unit(tmp_path: Path) -> None:
    path = tmp_path / "part.nc"
    text = NARROW["inches"].decode().replace("E[480.+#1*20]", "E2000.")
    path.write_text(text, encoding="utf-8")
    said = [warning for warning in grind(read_file(path), shop()).warnings if "the table of" in warning]
    assert len(said) == 1 and "E50800 is more than" in said[0]
    assert said[0].endswith("lower E, or write E78.7 if E2000 is meant in mm/min")
