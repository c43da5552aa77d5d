"""Public names of the package: they agree with the commands and import nothing heavy before their use."""

import json
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import pytest

import grind_env
from grind_env.errors import GrindError
from grind_env.machine.job import JobError
from tests.command import Grind

PLATE = grind_env.examples.path("plate_g82.nc")


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = "import sys, grind_env; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    heavy = {"pandas", "matplotlib", "scipy", "jinja2", "torch", "grind_env.shop", "grind_env.machine.grind"}
    assert not set(loaded) & (heavy | {"numpy", "numba", "gymnasium"})


@pytest.mark.parametrize(
    ("words", "heavy"),
    [
        (
            ("check", PLATE),
            ("grind_env.render", "grind_env.process", "agents", "torch", "matplotlib", "pandas", "numba"),
        ),
        (("tasks",), ("agents", "torch", "stable_baselines3", "matplotlib", "pandas", "PIL")),
    ],
)
def test_a_command_imports_no_heavy_module_without_need(words: tuple[object, ...], heavy: tuple[str, ...]) -> None:
    code = "import sys\nfrom grind_env.cli import main\ntry:\n    main(sys.argv[1:])\nfinally:\n    print(*sys.modules)"
    command = [sys.executable, "-c", code, *map(str, words)]
    loaded = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[-1].split()
    assert "grind_env.cli" in loaded and not [
        name for name in loaded if name.startswith(("agents", "torch", "matplotlib", "pandas", *heavy))
    ]


USE_ALL = """
import sys, types
tried = []
sys.meta_path.insert(0, types.SimpleNamespace(find_spec=lambda name, *_: tried.append(name.partition(".")[0])))
import gymnasium, grind_env
for name in [name for name in gymnasium.registry if name.startswith("grind/")]:
    for env in gymnasium.make(name), gymnasium.make_vec(name, num_envs=2):
        env.reset(seed=0)
        env.step(env.action_space.sample())
print(*tried)
"""


def test_every_env_loads_and_needs_no_optional_package() -> None:
    tried = subprocess.run([sys.executable, "-c", USE_ALL], capture_output=True, text=True, check=True).stdout.split()
    optional = {"torch", "stable_baselines3", "matplotlib", "pandas", "pyarrow", "cma", "typer", "rich"}
    assert "grind_env" in tried and not optional & {*tried}


@pytest.mark.parametrize(
    "imports",
    [
        "import gymnasium, grind_env",
        "import grind_env, gymnasium.envs.registration",
        # libraries look a module up without importing it, and notebooks reload edited modules
        "import grind_env, importlib.util; importlib.util.find_spec('gymnasium'); import gymnasium",
        "import grind_env, importlib; importlib.reload(grind_env.envs); importlib.reload(grind_env); import gymnasium",
    ],
)
def test_environments_are_registered_in_every_order_of_imports(imports: str) -> None:
    code = f"{imports}; print(sorted(name for name in gymnasium.registry if name.startswith('grind/')))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert found.strip() == str(sorted(name for name in gym.registry if name.startswith("grind/")))
    assert "grind/PowerLimited-v0" in found and "grind/Job-v0" in found


def test_every_public_name_is_listed_and_documented() -> None:
    for name in grind_env.__all__:
        assert name in dir(grind_env)
        assert getattr(grind_env, name).__doc__
    with pytest.raises(AttributeError, match="no attribute 'grid'"):
        _ = grind_env.grid


@pytest.mark.parametrize("name", grind_env.examples.names())
def test_every_example_runs_with_the_job_beside_it(name: str) -> None:
    assert grind_env.grind(grind_env.examples.path(name)).parts.size > 0


def test_an_unknown_example_suggests_a_similar_name() -> None:
    with pytest.raises(GrindError, match=r"did you mean plate_g82.nc"):
        grind_env.examples.path("plate_g83.nc")


def test_grind_returns_the_results_of_the_run_command(grind: Grind) -> None:
    status, out, _ = grind("run", PLATE, "--set", "#101=5", "--dress-at", 12, "--json")
    record = grind_env.grind(PLATE, variables={101: 5.0}, dress_at=[12.0])
    said = json.loads(out)
    assert status == 0
    assert said["seconds"] == record.seconds
    assert [part["Ra"] for part in said["parts"]] == record.parts["Ra"].tolist()
    assert len(said["dresses"]) == len(record.dresses) == 2


def test_grind_accepts_a_loaded_program_only_with_a_job() -> None:
    program, job = grind_env.read_program(PLATE), grind_env.load_job(PLATE.with_suffix(".toml"))
    assert grind_env.grind(program, job).seconds == grind_env.grind(PLATE).seconds
    with pytest.raises(JobError, match=r"plate_g82.nc.*give one"):
        grind_env.grind(program)


def test_sweep_returns_the_best_cost_of_the_sweep_command(grind: Grind) -> None:
    words = ("--E", "12000..20000", "--dress-every", "1..2", "--parts", 2)
    said = json.loads(grind("sweep", PLATE, *words, "--json")[1])
    pairs = grind_env.sweep(PLATE, E=(12_000, 20_000), dress_every=(1, 2), parts=2)
    assert said["best"]["cost"]["value"] == pairs.best.cost.value


def test_optimise_starts_the_same_search_as_its_command(grind: Grind, monkeypatch: pytest.MonkeyPatch) -> None:
    class Asked(Exception):
        pass

    def find_words(program: Path, job: Path | None, options: object, **others: object) -> None:
        asked.append((options, others["seconds"]))
        raise Asked

    asked: list[tuple[object, object]] = []
    monkeypatch.setattr(pytest.importorskip("grind_env.shop.optimise.optimisation"), "find_words", find_words)
    words = ("--vary", "E,J", "--bounds", "E=5000..25000,J=.002...02", "--fix", "N80")
    with pytest.raises(Asked):
        grind("optimise", PLATE, *words, "--margin", "power=.85", "--margin", "Ra=0.9", "--budget", "2min")
    with pytest.raises(Asked):
        bounds, margin = {"E": (5000, 25000.0), "J": (0.002, 0.02)}, {"power": 0.85, "Ra": 0.9}
        grind_env.optimise(PLATE, vary=("E", "J"), bounds=bounds, margin=margin, fix=[80], budget=120)
    assert asked[0] == asked[1]


def test_report_writes_the_same_file_as_its_command(grind: Grind, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    by_call = grind_env.report(PLATE, output=tmp_path / "a.html")
    grind("report", PLATE, "-o", tmp_path / "b.html")
    assert by_call.read_bytes() == (tmp_path / "b.html").read_bytes()
