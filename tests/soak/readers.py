"""Commands and public functions that read files, with a valid file of every kind."""

import functools
import io
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

import grind_env
from agents.benchmark.results import PARQUET
from grind_env.cli import main
from grind_env.policies.policy_lookup import chosen_policy
from grind_env.policies.problem_lookup import find_problem
from tests.shop.programs import TWO_PLATES
from tests.soak.hostile import mutated, named, tensors
from tests.test_files import READERS

PACKAGE = Path(grind_env.__file__).parent
READINGS = (
    '{"mean_power": 2600, "peak_power": 2900}\n{"mean_power": 1700, "peak_power": 1900, "size_error": 1.5}\n'
    '{"E": 12000, "D": 1}\n{"Ra": 0.3, "new_lot": 1, "new_wheel": 0, "diameter": 298.9}\n'
)
MEASURED = (
    "mean_power,first_power,peak_power,size_error,Ra,new_lot\n2600,2500,2900,,,\n1700,,1900,1.5,,1\n,,,,,\n,,,,.3,0\n"
)
GAUGED = "part,size [um],Ra,burn,diameter\n1,2,.3,no,299.8\n"
SETTINGS = (
    "table_speed [m/min];downfeed [µm];volume;power [kW];Ra\n8;5;40;.4;.3\n8;15;40;1.1;.4\n14;5;40;.6;.35\n"
    "14;15;40;1.7;.5\n20;5;40;.8;.4\n20;15;40;2.2;.6\n"
)
MAP = '[log]\ntime = "time"\npower = 2\npower_unit = "W"\nscale = 1.05\n[gauge]\nsize = "size"\nsize_unit = "um"\n'
TASK = 'base = "power_limited"\nblocks = 4\n[setup]\nwheel = "a60j"\n[catalogue]\nfiles = ["shop.toml"]\n'
PLANT = "meter:7"
NAME = "plant.txt"  #: file whose content replaces its name in a command line
PARTS = "\n[[parts]]\nstock = 0.11\n[parts.factors]\nkA = 1.1\n"
LEFT_OUT = re.compile(r"^#(\w+ = .)", re.MULTILINE)  #: pattern of a commented-out key in the job file of `grind init`


@dataclass(frozen=True, slots=True)
class Read:
    """Command or function that reads a file."""

    file: str  # name of the file in the folder of `good_files`
    words: str | Callable[[Path], object]  # words of the command, or a function of the path
    seconds: float = 10.0  # limit of the processor time, s
    change: Callable[..., bytes] = mutated  # function that makes the file hostile
    weight: float = 1.0  # relative frequency
    typed: str = "readings.jsonl"  # name of the file that is the standard input


ADVISE = "advise part.nc --parts 2 --policy handbook --json"
LOOKING_ON = "advise part.nc --parts 2 --policy guarded:handbook --json --shadow"
CALIBRATE = "calibrate log.csv --program part.nc --job part.toml"
PLAN = "calibrate --plan out.nc --program part.nc --job part.toml"
OUT = "--record out.csv"
SWEEP = "sweep part.nc --parts 2 --E 8000..9000 --dress-every 1..2 -o out.nc"
OPTIMISE = "optimise part.nc --parts 2 --budget 0.1s -o out.nc"
ON_PLANTS = (
    *(f"run part.nc {OUT}", "run part.nc --json", "report part.nc -o out.html", OPTIMISE),
    "evaluate --policy E12000D1 --episodes 2",
    "evaluate --program part.nc --policy E12000D1 --episodes 2",
    "play --policy handbook --no-window --output out.nc",
)
#: all commands and functions that read a file; the functions are listed in `tests.test_files`
READS = (
    Read("part.nc", "check part.nc", weight=3.0),
    Read("part.nc", "check part.nc --job part.toml --json", weight=2.0),
    Read("part.nc", "trace part.nc --strokes 3"),
    Read("part.nc", f"run part.nc {OUT}", weight=3.0),
    Read("part.nc", "report part.nc -o out.html", weight=0.5),
    Read("part.nc", "evaluate --program part.nc --policy E12000D1 --episodes 2"),
    Read("part.nc", "play --program part.nc --policy E12000D1 --no-window --output out.nc"),
    Read("part.nc", SWEEP, 30.0, weight=0.2),
    Read("part.nc", OPTIMISE, 60.0, weight=0.1),
    Read("part.nc", ADVISE),
    Read("part.nc", "train part.nc --parts 2 --steps 10000 --episodes 2 -o out.safetensors", 240.0, weight=0.1),
    Read("O9100.nc", f"run calling.nc --job part.toml {OUT}"),
    Read("part.toml", f"run part.nc {OUT}", weight=4.0),
    Read("part.toml", "run part.nc --json", weight=2.0),
    Read("part.toml", "check part.nc --job part.toml"),
    Read("part.toml", "report part.nc -o out.html", weight=0.5),
    Read("part.toml", ADVISE),
    Read("part.toml", "evaluate --program part.nc --policy handbook --episodes 2"),
    Read("stations.toml", f"run stations.nc {OUT}", weight=2.0),
    Read("rich.toml", f"run part.nc --job rich.toml {OUT}", weight=2.0),
    Read("shop.toml", "catalogue --file shop.toml", weight=2.0),
    Read("shop.toml", "catalogue wheel our_a60j --file shop.toml --json"),
    Read("shop.toml", f"run part.nc --job shop_job.toml {OUT}", weight=2.0),
    Read("entries.toml", "catalogue --file entries.toml", weight=2.0),
    Read("task.toml", "tasks task.toml", weight=2.0),
    Read("task.toml", "tasks task.toml --json"),
    Read("task.toml", "evaluate --task task.toml --policy E12000D1 --episodes 2", weight=2.0),
    Read("task.toml", "play --task task.toml --policy handbook --no-window --output out.nc"),
    Read("whole_task.toml", "tasks whole_task.toml", weight=2.0),
    Read("whole_task.toml", "figure dress --env whole_task.toml --dress-every 2 -o out.svg", weight=0.3),
    Read("whole_task.toml", "evaluate --task whole_task.toml --policy E12000D1 --episodes 2"),
    Read("agent.safetensors", "evaluate --policy agent.safetensors --episodes 2", change=tensors, weight=4.0),
    Read("agent.zip", "evaluate --policy agent.zip --episodes 2"),
    Read("row.json", "verify row.json", weight=3.0),
    Read("row.json", "verify row.json --seed 31415926535897932384 --episodes 2", 60.0),
    Read("measured.csv", f"{ADVISE} --measurements measured.csv", weight=3.0),
    Read("measured.csv", f"{LOOKING_ON} --measurements measured.csv"),
    Read("readings.jsonl", ADVISE, weight=3.0),
    Read("readings.jsonl", f"{LOOKING_ON} --max-step 2 --bounds 5000 20000"),
    Read("kept.advise.json", f"{ADVISE} --state kept.advise.json", weight=3.0, typed="further.jsonl"),
    Read("kept.advise.csv", f"{ADVISE} --state kept.advise.json", typed="further.jsonl"),
    Read("values.nc", f"{ADVISE} --write values.nc"),
    Read("log.csv", f"{CALIBRATE} -o out.toml", 60.0),
    Read("log.csv", f"{CALIBRATE} --report out.html", 60.0, weight=0.3),
    Read("gauge.csv", f"{CALIBRATE} --gauge gauge.csv -o out.toml", 60.0),
    Read("map.toml", f"{CALIBRATE} --columns map.toml", 60.0),
    Read("map.toml", f"{CALIBRATE} --columns map.toml -o out.toml --force", 60.0),
    *(Read(name, PLAN, 30.0) for name in ("part.nc", "part.toml")),
    Read("settings.csv", "calibrate settings.csv --job part.toml -o out.toml", 60.0),
    Read("tuned/oracle6.toml", "evaluate --task oracle6 --policy handbook --parameters tuned --episodes 2", weight=2.0),
    Read("tuned/oracle6.toml", lambda path: _tuned(path.parent), weight=2.0),
    *(Read(NAME, f"{words} --plant {NAME}", 30.0, named) for words in ON_PLANTS),
    Read("plant.toml", f"run part.nc --job plant.toml {OUT}", change=named, weight=2.0),
    Read("plant.toml", "check part.nc --job plant.toml", change=named),
    Read("plant.toml", "report part.nc --job plant.toml -o out.html", change=named, weight=0.3),
    Read("plant.toml", "evaluate --program part.nc --job plant.toml --policy E12000D1 --episodes 2", 30.0, named),
    Read("plant.toml", f"{SWEEP} --job plant.toml", 30.0, named, weight=0.2),
    Read("plant.toml", f"{OPTIMISE} --job plant.toml", 60.0, named, weight=0.1),
    Read("plant.toml", f"{ADVISE} --job plant.toml", change=named),
    Read("plant_task.toml", "tasks plant_task.toml", change=named),
    Read("plant_task.toml", "evaluate --task plant_task.toml --policy E12000D1 --episodes 2", 30.0, named),
    Read("plant_task.toml", "play --task plant_task.toml --policy handbook --no-window --output out.nc", 30.0, named),
    *(
        Read(f"read/{name}", read, change=tensors if name.endswith(".safetensors") else mutated)
        for name, read in READERS.items()
    ),
)


def _tuned(folder: Path) -> object:
    return chosen_policy("handbook", find_problem("oracle6").simulation(), folder)


def good_files(folder: Path) -> None:
    """Write a valid file of every kind."""
    os.chdir(folder)
    call(f"init {folder}")
    for path in (TWO_PLATES, TWO_PLATES.with_suffix(".toml")):
        shutil.copy(path, folder / f"stations{path.suffix}")
    part = (folder / "part.toml").read_text("utf-8")
    before, behind = part.split("[setup]")
    texts = {
        "readings.jsonl": READINGS,
        "further.jsonl": "".join(READINGS.splitlines(keepends=True)[1:]),
        "measured.csv": MEASURED,
        "gauge.csv": GAUGED,
        "settings.csv": SETTINGS,
        "map.toml": MAP,
        "task.toml": TASK,
        NAME: PLANT,
        "plant.toml": f'plant = "{PLANT}"\n{part}',
        "plant_task.toml": f'plant = "held-out:5"\n{TASK}',
        "whole_task.toml": (PACKAGE / "envs" / "tasks" / "job_shop.toml").read_text("utf-8"),
        "values.nc": "#101=12000.\n#102=1\n",
        "rich.toml": "[setup]".join([before, LEFT_OUT.sub(r"\1", behind)]) + PARTS,
        "shop_job.toml": part,
    }
    program = (folder / "part.nc").read_text("utf-8")
    split = program.rfind("\nO")
    texts |= {"calling.nc": program[: split + 1], f"O{program[split + 2 : split + 6]}.nc": program[split + 1 :]}
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    shutil.copy(PACKAGE / "process" / "catalogue_data" / "wheels.toml", folder / "entries.toml")
    agent = PACKAGE / "policies" / "shipped" / "plain_gru" / "power_limited.safetensors"
    shutil.copy(agent, folder / "agent.safetensors")
    shutil.make_archive(str(folder / "agent"), "zip", PACKAGE / "policies" / "shipped")
    for name in ("tuned", "read"):
        (folder / name).mkdir()
    shutil.copy(PACKAGE / "policies" / "parameters" / "oracle6.toml", folder / "tuned" / "oracle6.toml")
    call("evaluate --task oracle6 --policy E12000D1 --episodes 2 --submit row.json")
    call(f"{ADVISE} --state kept.advise.json", READINGS.splitlines()[0].encode())
    _files_of_readers(folder / "read", folder, agent)


@functools.cache
def good_folder() -> Path:
    """Return the folder with the valid files of this process."""
    before, folder = Path.cwd(), Path(tempfile.mkdtemp(prefix="soak-good-"))
    good_files(folder)
    os.chdir(before)
    return folder


@contextmanager
def copied(**beside: str) -> Iterator[Path]:
    """Change into a copy of the valid files; `secret_txt="a"` writes a file secret.txt next to the copy."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory(prefix="soak-copy-") as base:
        for stem, text in beside.items():
            Path(base, stem.replace("_", ".")).write_text(text)
        shutil.copytree(good_folder(), inside := Path(base, "inside"))
        os.chdir(inside)
        try:
            yield inside
        finally:
            os.chdir(before)


def _files_of_readers(place: Path, folder: Path, agent: Path) -> None:
    results = PACKAGE.parent / "agents" / "results"
    copies = {
        "part.nc": folder / "part.nc",
        "part.toml": folder / "part.toml",
        "shop.toml": folder / "shop.toml",
        "called.toml": folder / "shop.toml",
        "scores.toml": PACKAGE / "envs" / "scores.toml",
        "tuned.toml": folder / "tuned" / "oracle6.toml",
        "policy.safetensors": agent,
        "measured.safetensors": agent,
        "study.csv": results / "dress_study" / "rush.csv",
        PARQUET: results / PARQUET,
    }
    for name, path in copies.items():
        shutil.copy(path, place / name)


@dataclass(frozen=True, slots=True)
class CommandResult:
    """Exit status and output of a command."""

    status: int
    out: str
    error: str


def call(words: str, typed: bytes = b"") -> CommandResult:
    """Run a command of `grind` in this process."""
    name = Path(NAME)
    typed_words = [name.read_text("utf-8", "surrogateescape") if each == NAME else each for each in words.split()]
    out, error = io.StringIO(), io.StringIO()
    stdin = io.TextIOWrapper(io.BytesIO(typed), encoding="utf-8")
    try:
        with redirect_stdout(out), redirect_stderr(error), patch.object(sys, "stdin", stdin):
            main(typed_words)
    except SystemExit as end:
        return CommandResult(int(end.code or 0), out.getvalue(), error.getvalue())
    raise AssertionError("a command ends by SystemExit")


def contents(folder: Path) -> Mapping[str, bytes | None]:
    """Return the contents of all files below a folder by their paths; None for links, folders and the like."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() if path.is_file() and not path.is_symlink() else None
        for path in sorted(folder.rglob("*"))
    }
