"""An agent serves the part, program, prices and task of its training and refuses any other."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from agents import train_sb3
from grind_env import examples
from grind_env.envs.job.loading import load_simulation
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.policies.learned.saved import OtherPart, load_policy
from grind_env.policies.problem_lookup import find_problem
from tests.command import Grind
from tests.shop.advising import saved_agent

PLATE, JOB = (examples.path("plate_g82.nc").with_suffix(suffix).read_text() for suffix in (".nc", ".toml"))
PARTS = 2
JUMP = PLATE.replace("N60 M01", "N60 GOTO 65\nN62 G04 P1.\nN65 G04 P2.\nN66 M01")
CATALOGUE = """
[catalogue.material.aisi_52100]
base = "aisi_52100"
chip_energy = 15.0

[catalogue.machine.default]
base = "default"
idle_power = 1000.0
power_limit = 8600.0
"""
CALIBRATION = """
[catalogue.uncertainty]
names = ["material.chip_energy"]
spread = [0.1]
correlation = [[1.0]]
"""


def written(folder: Path, program: str = PLATE, job: str = JOB, name: str = "part.nc") -> Path:
    path = folder / name
    path.write_text(program)
    path.with_suffix(".toml").write_text(job)
    return path


def simulation(path: Path, parts: int = PARTS, variables: dict[int, float] | None = None) -> Simulation:
    return load_simulation(str(path), None, parts, 1.0, "measured", variables or {})


@pytest.fixture
def agent(tmp_path: Path) -> Path:
    """Return an agent for `part.nc`, which lies beside it."""
    return saved_agent(tmp_path / "agent.safetensors", find_problem(str(written(tmp_path)), None, PARTS))


def changed(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)


def in_setup(line: str) -> tuple[str, str]:
    return "[setup]", f"[setup]\n{line}"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"aisi_52100"', '"inconel_718"', "part.material.name is 'inconel_718', but was 'aisi_52100'"),
        ('"a60j"', '"sg60j"', "setup.wheel.name is 'sg60j', but was 'a60j'"),
        ("stock = 0.2", "stock = 0.21", "part.stock is 0.21, but was 0.2"),
        ("wheel_speed = 30", "wheel_speed = 30.001", "setup.wheel_speed is 30.001, but was 30"),
        ("load = 20", "load = 20\nwheel_change = 300", "times.wheel_change is 300, but was left out"),
        ("[times]", "[lots]\nprobability = 0.5\n\n[times]", "lots.probability is 0.5, but was 0.16666666666666666"),
        ("y = 10", "y = 11", "diamond.y is 11, but was 10"),
        (*in_setup("wheel_overrides = { price = 0.01 }"), "setup.wheel.price is 0.01, but was 0.0001"),
        (*in_setup('coolant = "always on"'), "setup.coolant is 'always on', but was 'by program'"),
        (
            "# [lots]",
            "[[part.stages]]\nstock = 0.15\n# [lots]",
            r"part.stages.1.stock is 0.15, but was left out; part.stages.1.roughness_limit is .*; and 1 more",
        ),
        # an entry of the same name with another number is no calibration
        ("[setup]", f"{CATALOGUE}\n[setup]", "part.material.chip_energy is 15, but was 13.8"),
    ],
)
def test_an_agent_of_another_job_is_refused_with_the_change(
    old: str, new: str, said: str, agent: Path, tmp_path: Path
) -> None:
    other = simulation(written(tmp_path, job=changed(JOB, old, new)))
    with pytest.raises(OtherPart, match=f"agent.safetensors was trained for another part: {said}.*--other-part"):
        load_policy(agent, simulation=other)
    assert "was trained for another part" in load_policy(agent, simulation=other, other_part=True).remark


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("E15000.", "E14000.", "program block 5 E is '14000.', but was '15000.'"),
        ("E9000.", "", "program block 7 E is left out, but was '9000.'"),
        ("Y-.02 F60.", "Y-.03 F60.", "O9100 block 5 Y is '-0.03', but was '-0.02'"),
        ("N60 M01", "/N60 M01", "program block 6 / is '/', but was left out"),
        (
            "N80 G80",
            "#101=5\nN80 G80",
            "program block 8 text is '#101=5', but was left out; program block 9 G is '80', but was '0'",
        ),
    ],
)
def test_an_agent_of_another_program_is_refused_with_the_change(
    old: str, new: str, said: str, agent: Path, tmp_path: Path
) -> None:
    with pytest.raises(OtherPart, match=f"was trained for another part: (.*; )?{said}"):
        load_policy(agent, simulation=simulation(written(tmp_path, changed(PLATE, old, new))))


def test_another_number_of_parts_or_another_variable_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, changed(PLATE, "E15000.", "E#101"))
    agent = saved_agent(tmp_path / "a.safetensors", find_problem(str(written(tmp_path)), None, PARTS))
    with pytest.raises(OtherPart, match="was trained for part_x2, not for part_x3: number of parts is 3, but was 2"):
        load_policy(agent, simulation=simulation(path, 3))
    written(tmp_path, changed(PLATE, "E15000.", "E#101"))
    with pytest.raises(OtherPart, match=r"variables.101 is 14000, but was left out; program block 5 E is '#101'"):
        load_policy(agent, simulation=simulation(path, variables={101: 14000.0}))


@pytest.mark.parametrize(
    "change",
    [
        lambda program, job: (changed(program, "(ROUGH:", "\n(SCHRUPPEN:"), f"# mine\n{job}"),
        lambda program, job: (changed(changed(program, "N50", "N55"), "N70 ", "n71"), job),
        lambda program, job: (changed(program, "X230. I-30.", "i-30.0  X0230."), job),
        lambda program, job: (
            program,
            job + CATALOGUE.replace(".aisi_52100", ".unused").replace(".default", ".unused"),
        ),
        lambda program, job: (program, changed(job, '"aisi_52100"', '"100Cr6"')),
        lambda program, job: (program, f"{job}\n[wheel]\ndiameter = 280\nwear_flat_area = 0.02"),
        lambda program, job: (program, f'plant = "meter:7"\n{job}'),
        lambda program, job: (program, f"{job}\n[lots]"),
    ],
    ids=["comments", "N words", "numbers", "unused entry", "alias", "worn wheel", "machine", "default"],
)
def test_changes_without_effect_on_the_simulation_are_accepted(
    change: Callable[[str, str], tuple[str, str]], agent: Path, tmp_path: Path
) -> None:
    assert not load_policy(agent, simulation=simulation(written(tmp_path, *change(PLATE, JOB)))).remark


def test_a_program_may_be_renamed(agent: Path, tmp_path: Path) -> None:
    other = simulation(written(tmp_path, name="plate.nc"))
    policy = load_policy(agent, simulation=other)
    policy.begin(other, 1)
    assert (policy.task_name, policy.remark) == ("plate_x2", "")


def test_n_words_matter_only_as_jump_targets(tmp_path: Path) -> None:
    agent = saved_agent(tmp_path / "a.safetensors", find_problem(str(written(tmp_path, JUMP)), None, PARTS))
    moved = changed(changed(JUMP, "N62", "N99"), "N65", "N62")
    other = simulation(written(tmp_path, changed(changed(moved, "N62", "N65"), "N99", "N62")))
    assert not load_policy(agent, simulation=other).remark
    swapped = changed(changed(changed(JUMP, "N62", "N99"), "N65", "N62"), "N99", "N65")
    with pytest.raises(OtherPart, match="program block 7 N is '65', but was '62'"):
        load_policy(agent, simulation=simulation(written(tmp_path, swapped)))


def test_a_job_calibrated_after_the_training_gives_a_remark(agent: Path, tmp_path: Path) -> None:
    found = load_policy(agent, simulation=simulation(written(tmp_path, job=JOB + CATALOGUE + CALIBRATION)))
    said = "was trained before the job was calibrated: part.material.chip_energy is 15, but was 13.8; "
    # the power readings then have another scale, too
    said += "setup.machine.power_limit is 8600, but was 7500; setup.machine.idle_power is 1000, but was 0"
    assert found.remark == f"{agent} {said}; train it anew to use that"
    # any other change makes another part
    other = changed(JOB, "stock = 0.2", "stock = 0.3") + CATALOGUE + CALIBRATION
    with pytest.raises(
        OtherPart, match=r"part.material.chip_energy is 15, but was 13.8; part.stock is 0.3, but was 0.2; .* 1 more"
    ):
        load_policy(agent, simulation=simulation(written(tmp_path, job=other)))


def task_file(folder: Path, more: str = "") -> Path:
    path = folder / "shop.toml"
    path.write_text(f'base = "oracle6"\ntitle = "mine"\n{more}')
    return path


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("blocks = 12", "blocks is 12, but was 6"),
        ("[setup]\nload = 99", "setup.load is 99, but was 20"),
        ("[setup]\nwheel_overrides = { price = 0.5 }", "setup.wheel.price is 0.5, but was"),
        ("[spread]\nmeasurement = 3.0", "spread.measurement is 3, but was"),
    ],
)
def test_an_agent_of_another_task_file_is_refused(more: str, said: str, tmp_path: Path) -> None:
    path = task_file(tmp_path)
    agent = saved_agent(tmp_path / "a.safetensors", find_problem(str(path)))
    assert not load_policy(agent, simulation=find_problem(str(path)).simulation()).remark
    task_file(tmp_path, more)
    with pytest.raises(OtherPart, match=said):
        load_policy(agent, simulation=find_problem(str(path)).simulation())


def test_an_agent_without_record_is_accepted_for_bundled_problems_only(tmp_path: Path) -> None:
    unsaid = tmp_path / "old.safetensors"
    for problem in (find_problem("oracle6"), find_problem(str(examples.path("plate_g82.nc")), None, PARTS)):
        saved_agent(unsaid, problem, inputs=None)
        assert not load_policy(unsaid, simulation=problem.simulation()).remark
    with pytest.raises(OtherPart, match="was trained for plate_g82_x2, not for slot"):
        load_policy(unsaid, simulation=find_problem("slot").simulation())
    copy = written(tmp_path, name="plate_g82.nc")
    with pytest.raises(OtherPart, match=r"old.safetensors does not say for what part it was trained: train another"):
        load_policy(unsaid, simulation=simulation(copy))
    assert load_policy(unsaid, simulation=simulation(copy), other_part=True).remark.endswith("it was trained")


@pytest.mark.parametrize("inputs", [[], "x", {"part.stock": []}, {"part.stock": None}])
def test_a_damaged_record_is_refused(inputs: Any, tmp_path: Path) -> None:
    path = saved_agent(tmp_path / "a.safetensors", find_problem("oracle6"), inputs=inputs)
    with pytest.raises(ValueError, match="description is damaged"):
        load_policy(path)


def test_commands_use_an_agent_of_another_part_only_on_request(grind: Grind, agent: Path, tmp_path: Path) -> None:
    program = written(tmp_path, job=changed(JOB, "stock = 0.2", "stock = 0.19"))
    readings = tmp_path / "readings.csv"
    readings.write_text("mean_power\n2600\n")
    of_batch = ("--parts", PARTS, "--policy", agent)
    asked = ("--program", program, *of_batch)
    said = f"{agent} was trained for another part: part.stock is 0.19, but was 0.2"
    for words in (
        ("advise", program, *of_batch, "--measurements", readings),
        ("evaluate", *asked, "--episodes", 2),
        ("play", *asked, "--no-window"),
    ):
        status, out, told = grind(*words)
        assert (status, out) == (2, "") and told.startswith(f"grind: {said}: train another agent")
        status, out, told = grind(*words, "--other-part")
        assert status == 0 and out and told == f"{said}\n"
    # with a guard, and on other machines
    words = ("evaluate", *asked[:-1], f"guarded:{agent}", "--episodes", 2, "--plant", "held-out")
    assert said in grind(*words)[2] and grind(*words, "--other-part")[0] == 0


def test_evaluate_prints_the_training_machines_of_an_agent(grind: Grind, tmp_path: Path) -> None:
    saved_agent(tmp_path / "a.safetensors", find_problem("oracle6"), machines="public")
    words = ("evaluate", "--env", "oracle6", "--policy", tmp_path / "a.safetensors", "--episodes", 2)
    assert grind(*words)[1].strip().endswith("; sees measurements, trained on public machines")
    assert '"trained_on": "public"' in grind(*words, "--json")[1]


def test_agents_are_not_trained_on_held_out_machines(tmp_path: Path) -> None:
    output = tmp_path / "agent.zip"
    words = ["--task", str(task_file(tmp_path, 'plant = "held-out:3"')), "--output", str(output)]
    with pytest.raises(GrindError, match="but these machines judge agents: train on training, public, laws or model"):
        train_sb3.app(words, standalone_mode=False)
    assert not output.exists()
