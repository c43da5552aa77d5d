"""Page and CSV table of the study."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from agents.benchmark.figures import write_figure
from agents.csv_tables import csv_of, csv_rows
from agents.plants.figure import plants_figure
from agents.plants.program_variants import batch
from agents.plants.promises import COLUMNS, family_rows, promises
from agents.plants.shop_log import DRESSED, FEEDS
from agents.plants.study_machines import FAMILY_NAMES, PROGRAMS, StudyMachine, StudyProgram, machines
from agents.plants.trials import HOURS, QUESTIONS, Found, PlantsTrial, answer, code
from agents.provenance import commit
from agents.study import Study, StudyOptions
from grind_env.data_table import Column, table_of
from grind_env.errors import GrindError
from grind_env.files import is_file
from grind_env.machine.job.job_file import job_beside, load_job
from grind_env.message_text import did_you_mean, quoted
from grind_env.policies.tuned_parameters import write_whole
from grind_env.task_version import TASK_VERSION

CSV, PAGE, PICTURE = "plants.csv", "plants.md", "figures/plants.png"
TITLE = "# The shop tools on out-of-model machines"
SAID = """\
`python -m agents plants`: means over the machines of a [family](../../docs/plants.md); costs in $ per part. Each tool
works on a machine whose physics the model does not have.

- *calibrate*: relative error of the predicted power (`catalogue`: without calibration; `regression`: a power law).
- *optimise*: cost of the original program, and of the program found without a calibration, with one, and with the
  machine itself as the model (`known`). `refused`: share of the machines whose calibration was refused; there the
  uncalibrated program counts. One machine of each family.
- *advise*: `plan` is the best of 15 fixed plans, `floor` an adviser without a model, `trusting` the adviser without
  its guard.
- *robust*: an agent that was trained for the program on other machines of all families.

Logs have the gain and idle power of a meter, but not its lag or the drift of a gauge."""
HEADER = ("question", "program", "plant", "what", "value", "commit", "task_version")
BEGINS = {CSV: ",".join(HEADER[:-1]), PAGE: TITLE}
SHOWN = "Cost of a part, a dot for each machine and program"
ASKED = (
    Column("question", lambda item: item[0]),
    Column("number", lambda item: item[1].what),
    Column("found", lambda item: item[1].found, ".3g"),
    Column("promised", lambda item: f"{'at least' if item[1].at_least else 'at most'} {item[1].asked:g}"),
    Column("holds", lambda item: "yes" if item[1].kept else "NO"),
)


def study(asked: StudyOptions, family: Sequence[str] | None, question: Sequence[str] | None) -> Study:
    """Return the study that asks every question of every machine."""
    programs = programs_of(
        None if asked.tasks is None else [name.strip() for name in asked.tasks.split(",")], asked.job
    )
    families, questions = _chosen("--family", family, FAMILY_NAMES), _chosen("--question", question, tuple(QUESTIONS))
    runs = asked.options.runs.absolute()
    # a search takes 25 s, three times on each machine
    seeds = dict.fromkeys(questions, asked.seeds) | {"optimise": 1}
    return Study(
        name="plants",
        title="",
        trials=[
            PlantsTrial(each, machine, asked.episodes, runs)
            for each in questions
            for machine in machines(families, seeds[each], programs)
        ],
        run=answer,
        decides=code,
        seconds=lambda cell: 3600.0 * HOURS[cell.question],
        publish=write,
        files=BEGINS,
    )


def _chosen(option: str, names: Sequence[str] | None, known: Sequence[str]) -> Sequence[str]:
    for name in names or ():
        if name not in known:
            raise GrindError(f"{option} is {quoted(name)}{did_you_mean(name, known)}: choose {', '.join(known)}")
    return tuple(dict.fromkeys(names)) if names else known


def write(found: Mapping[PlantsTrial, Found], folder: Path) -> str:
    """Write plants.csv and plants.md, in which answers to other questions stay; return the page."""
    questions, made_with = {cell.question for cell in found}, dict.fromkeys(found, commit())
    others, commits = read_csv(folder / CSV)
    answers = {cell: numbers for cell, numbers in others.items() if cell.question not in questions} | {**found}
    found = {cell: answers[cell] for cell in sorted(answers, key=lambda cell: [*QUESTIONS].index(cell.question))}
    drawn = plants_figure(found)
    text = page(found, drawn=drawn is not None)
    write_whole(folder / CSV, csv_text(found, commits | made_with))
    write_whole(folder / PAGE, text)
    if drawn is not None:
        (folder / PICTURE).parent.mkdir(exist_ok=True)
        write_figure(drawn, folder / PICTURE)
    return text


def read_csv(path: Path) -> tuple[dict[PlantsTrial, Found], dict[PlantsTrial, str]]:
    """Return the results of the present task version for programs of the study, and the commit of each cell."""
    if not path.exists():
        return {}, {}
    found, commits = dict[PlantsTrial, dict[str, float]](), dict[PlantsTrial, str]()
    for row in csv_rows(path):
        present = row.get("task_version") == str(TASK_VERSION)
        if present and row["program"] in PROGRAMS and row["question"] in QUESTIONS:
            cell = PlantsTrial(row["question"], StudyMachine(row["plant"], PROGRAMS[row["program"]]))
            found.setdefault(cell, {})[row["what"]] = float(row["value"])
            commits[cell] = row["commit"]
    return {**found}, commits


def csv_text(found: Mapping[PlantsTrial, Found], commits: Mapping[PlantsTrial, str]) -> str:
    """Return the results as CSV, a number per row, with the commit of each cell."""
    rows = (
        (cell.question, cell.machine.program.name, cell.machine.plant, what, f"{value:.6g}", commits[cell])
        for cell, numbers in found.items()
        for what, value in numbers.items()
    )
    return csv_of(HEADER, ((*row, TASK_VERSION) for row in rows))


def page(found: Mapping[PlantsTrial, Found], *, drawn: bool) -> str:
    """Return the tables as Markdown, below the figure if one is drawn."""
    parts = [
        TITLE,
        SAID,
        *([f"![{SHOWN}]({PICTURE})", f"*{SHOWN}. Dots beyond the axis are drawn at its end.*"] * drawn),
    ]
    for question in dict.fromkeys(cell.question for cell in found):
        columns = (name.replace("_", " ") for name in COLUMNS[question])
        listed = table_of(("family", "machines", *columns), family_rows(found, question))
        parts += [f"## {question}", listed.markdown()]
    parts += ["## Promises", table_of(ASKED, promises(found)).markdown()]
    return "\n\n".join(parts) + "\n"


def programs_of(names: Sequence[str] | None, job: str | None) -> list[StudyProgram]:
    """Return programs by their names or files; without names, the programs of the study."""
    names = list(dict.fromkeys(names or PROGRAMS))
    files = [name for name in names if name not in PROGRAMS]
    if job is not None and len(files) != 1:
        raise GrindError(f"--job needs exactly one --program that is a file: {len(files) or 'none'} named")
    programs = [PROGRAMS[name] if name in PROGRAMS else _of_file(name, job) for name in names]
    if len({each.name for each in programs}) < len(programs):
        raise GrindError("--program: two programs have the same name, by which results are cached: rename one")
    return programs


def _of_file(name: str, job: str | None) -> StudyProgram:
    path = Path(name)
    if not is_file(path):
        raise GrindError(
            f"--program is {quoted(name)}{did_you_mean(name, PROGRAMS)}: choose {', '.join(PROGRAMS)}, or name a file"
        )
    program = StudyProgram(path.stem, path.resolve(), (job_beside(path) if job is None else Path(job)).resolve())
    if load_job(program.job).uncertainty is not None:
        raise GrindError(f"{program.job.name} is calibrated, but the study calibrates: name another job")
    batch(program, FEEDS, DRESSED)
    return program
