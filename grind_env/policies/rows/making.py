"""Rows of evaluations, and what is made of a row: its files in a folder, its problem and its policy."""

import os
import platform
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from grind_env.control.reader import called_files
from grind_env.envs.names import ANY_TASK, FOLDER, OTHERS, environment_id, task_names
from grind_env.envs.simulation import Simulation
from grind_env.envs.splits import EVERY
from grind_env.envs.tasks.reading import files_of_task
from grind_env.envs.tasks.reading import is_file as is_task_file
from grind_env.errors import GrindError, quoted
from grind_env.files import beside, read_bytes
from grind_env.machine.job.file import files_of_job
from grind_env.plants.names import modules_of
from grind_env.policies.evaluation import Evaluation
from grind_env.policies.guard import Guarded
from grind_env.policies.learned.saved import SUFFIX
from grind_env.policies.naming import OWN, named_policy
from grind_env.policies.policy import Policy
from grind_env.policies.problem import JOB, Problem, find_problem
from grind_env.policies.registry import TUNED
from grind_env.policies.rows.form import RowError
from grind_env.policies.rows.row import AGENT, Episode, File, Row, stated
from grind_env.policies.tuned import Tuned, tuned_arguments, write_tuned
from grind_env.toml import read_toml

RULED = {"mpc": "full_state_rule"}
"""Whose parameters a policy takes that has none of its own."""


def row_of(
    run: Evaluation,
    problem: Problem,
    seeds: Sequence[int],
    policy: Policy,
    text: str = "",
    configs: Path | None = None,
    *,
    split: str = EVERY,
    plant: str = "",
    model: str = "",
    provenance: Mapping[str, str] | None = None,
) -> Row:
    """The row of an evaluation.

    Args:
        run: episode by episode.
        problem: what was ground.
        seeds: of the episodes.
        policy: what decided.
        text: that names it, as for `named_policy`; without one, as of a .zip, the row can only be replayed.
        configs: folder of the tuned parameters.
        split: that contexts were drawn from.
        plant: the machine, as `Judgement` has it.
        model: what it was taken for, likewise.
        provenance: more of what it was made with, such as a commit.

    Raises:
        RowError: no row can have that problem, policy or machine.
        GrindError: a file cannot be read.
    """
    name = text.removeprefix(Guarded.PREFIX)
    what, files = _texts(problem)
    if name.endswith(SUFFIX):
        files[AGENT] = File.of(read_bytes(Path(name)), text=False)
        text = text.replace(name, AGENT)
    own = OWN.fullmatch(name)
    for module in (*modules_of(plant), *modules_of(model), *([own[1]] if own else [])):
        source = getattr(sys.modules.get(module), "__file__", None) or ""
        if not source.endswith(".py") or not module.isidentifier():
            raise RowError(f"{module} is no file of its own that a row could carry: put what it names into one")
        files[f"{module}.py"] = File.of(read_bytes(Path(source)), text=False)
    rule, made_with = RULED.get(name, name), {"python": platform.python_version(), "processor": platform.machine()}
    made_with |= {each: version(each) for each in ("grind_env", "numpy", "numba")}
    row = Row(
        id=problem.id,
        **what,
        policy=policy.name,
        sees=policy.sees,
        says="" if name.endswith(".zip") else text,
        parameters=tuned_arguments(rule, problem.simulation().task, configs) if rule in TUNED else {},
        plant=plant,
        model=model,
        split=split,
        files=files,
        **stated(run),
        provenance={**made_with, **(provenance or {})},
        episodes=tuple(_episode(run, k, int(seed)) for k, seed in enumerate(seeds)),
    )
    with unpacked(row):  # whoever reads it must be able to
        return row


def _texts(problem: Problem) -> tuple[dict[str, Any], dict[str, File]]:
    """The fields of a row that say a problem, and the user's files that it is read from, below their common folder."""
    given = {key: value for key, value in problem.arguments if key != "plant"}
    named = {key: Path(os.path.normpath(given.pop(key))) for key in ("program", "job", "task") if key in given}
    parts = given.pop("parts", 1)
    if given:
        raise RowError(f"{problem.name} has the argument {min(given)}, which no row has: make it without")
    read = [*named.values()]
    if "task" in named:
        read += files_of_task(named["task"])
    if "program" in named:
        job = named.get("job") or beside(named["program"], ".toml")
        read += [*called_files(named["program"]), *files_of_job(job)]
    own = [Path(os.path.normpath(path)) for path in read if path.parent != FOLDER]
    folder = Path(os.path.commonpath([path.parent for path in own])) if own else Path()
    names = {path: path.relative_to(folder).as_posix() for path in own}
    files = {name: File.of(read_bytes(path), text=True) for path, name in names.items()}
    return {"parts": parts, **{key: names[path] for key, path in named.items()}}, files


@contextmanager
def unpacked(row: Row, modules: Sequence[str] = ()) -> Iterator[tuple[Problem, Path]]:
    """The problem of a row, and the folder of its files, which is gone afterwards; `modules` of it can be imported.

    Raises:
        GrindError: a name in it leads elsewhere, a text is faulty, or there is no such environment.
    """
    if row.id not in {*map(environment_id, (*task_names(), *OTHERS)), ANY_TASK}:
        raise RowError(f"id is {quoted(row.id)}, but must be that of an environment in which E and D are chosen")
    if (row.id == ANY_TASK) != bool(row.task) or (row.program and row.id != JOB):
        raise RowError(f"id is {quoted(row.id)}: a task goes with {ANY_TASK}, and a program with {JOB}")
    for key in ("program", "job", "task"):
        if (name := getattr(row, key)) and (name not in row.files or is_task_file(name) != (key != "program")):
            raise RowError(
                f"{key} is {quoted(name)}, but must be one of its files, and end in .toml if it is no program"
            )
    with TemporaryDirectory(prefix="grind-row-") as place, TemporaryDirectory(prefix="grind-row-") as code:
        folder = Path(place)
        for name, file in row.files.items():
            if not name.isprintable() or {"", ".", ".."} & {*name.split("/")} or {"\\", ":"} & {*name}:
                raise RowError(f"files has {quoted(name)}, but a name leads below the folder of the row")
            try:
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                (folder / name).write_bytes(file.data(name))
            except OSError as error:
                raise RowError(f"files.{quoted(name)} can be no file ({error.strerror}): rename it") from None
        known = {folder / name for name in row.files}
        for path in known:
            _refuse_elsewhere(path, known)
        for name in modules:  # alone: who trusts one has read no other
            Path(code, f"{name}.py").write_bytes(row.files[f"{name}.py"].data(name))
        before = {name: sys.modules.pop(name) for name in modules if name in sys.modules}
        path_before = sys.path.copy()
        try:
            sys.path[:0] = [code]
            job = str(folder / row.job) if row.job else None
            own = row.program or row.task
            yield find_problem(str(folder / own) if own else row.id, job, row.parts), folder
        finally:
            sys.path[:] = path_before
            for name in modules:
                sys.modules.pop(name, None)
            sys.modules.update(before)


def policy_of(row: Row, simulation: Simulation, folder: Path) -> Policy:
    """The policy of a row whose files lie in a folder; a GrindError if it is none, or not the one that the row says."""
    name = row.says.removeprefix(Guarded.PREFIX)
    plain: Any = {key: [*each] if isinstance(each, tuple) else each for key, each in row.parameters.items()}
    nothing: Any = dict.fromkeys(("training_cost", "validation_cost", "evaluations"), 0)
    tuned = Tuned(parameters=plain, training_seeds=[], validation_seeds=[], **nothing)
    with TemporaryDirectory(prefix="grind-row-") as place:
        write_tuned(simulation.task.name, {RULED.get(name, name): tuned} if plain else {}, Path(place))
        text = row.says.replace(AGENT, str(folder / AGENT))
        made = named_policy(text, simulation, Path(place), modules=bool(row.module))
    if (getattr(made, "name", None), getattr(made, "sees", None)) != (row.policy, row.sees):
        raise RowError(f"policy is {quoted(row.policy)} that sees {row.sees}, but what the row carries is another")
    return made


def _refuse_elsewhere(path: Path, known: set[Path]) -> None:
    """Refuse a file that, read as a task or a job, names one which is none of the row."""
    document: dict[str, Any] = {}
    with suppress(GrindError):  # of a program, or of what is refused as it is read
        document = read_toml(path)
    catalogue, base = document.get("catalogue"), document.get("base")
    files = catalogue.get("files") if isinstance(catalogue, Mapping) else None
    named = [each for each in files if isinstance(each, str)] if isinstance(files, list) else []
    for other in [*named, str(base)] if is_task_file(base) else named:
        if Path(os.path.normpath(path.parent / other)) not in known:
            raise RowError(f"{path.name} names the file {quoted(other)}, which is none of the row: name one beside it")


def _episode(run: Evaluation, k: int, seed: int) -> Episode:
    cost, good, finished = (float(each[k]) for each in (run.cost, run.good, run.finished))
    E, D = (tuple(each[k][each[k] == each[k]].tolist()) for each in (run.speeds, run.executions))
    return Episode(seed=seed, cost=cost, good=good, finished=finished, E=E, D=D)
