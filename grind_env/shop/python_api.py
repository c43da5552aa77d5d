"""Python calls of the commands `report`, `optimise`, `sweep` and `calibrate`, with their defaults.

Command-line texts are values here: `--bounds E=5000..25000` is `bounds={"E": (5000, 25000)}`. Calls import libraries of
the extra [shop] only when needed.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from grind_env.control import read_file
from grind_env.control.cli_options import interrupts_of
from grind_env.control.program_reader import called_files
from grind_env.files import beside, write_atomically
from grind_env.machine.grind import grind_file
from grind_env.machine.job import Job
from grind_env.machine.job.job_file import job_beside, load_job
from grind_env.output_checks import Target, check_targets
from grind_env.shop.search_options import CONFIDENCE, Ends, Number, ends_of, options_of, seconds_of, whole_ends_of
from grind_env.terminal_output import progress
from grind_env.toml import files_named

if TYPE_CHECKING:
    from grind_env.shop.calibrate.result import Calibration
    from grind_env.shop.optimise.result import Optimised
    from grind_env.shop.sweep.study import Sweep

File: TypeAlias = str | Path


def report(
    program: File,
    job: File | None = None,
    output: File | None = None,
    *,
    block_delete: bool = False,
    blocks: int | None = None,
    groove_retract: float | None = None,
    variables: Mapping[int, float] | None = None,
    dress_at: Sequence[float] = (),
    interrupts: Sequence[str] = (),
    plant: str | None = None,
) -> Path:
    """Simulate a program and write the results to one HTML file that works offline; return its path.

    Args:
        program: file of the part program.
        job: its job file; the program's name with `.toml` if None.
        output: the file to be written; the program's name with `.html` if None.
        block_delete: as in `grind_file`, like the arguments after it.
        blocks: greatest number of blocks and strokes.
        groove_retract: retract amount of G76 and G77, mm.
        variables: values of # variables at the start.
        dress_at: times at which the operator asks for a dress, s.
        interrupts: programs that the operator requests, such as `9200@12.5`.
        plant: name of the machine (`grind_env.plants`); the job's if None.

    Raises:
        MissingExtra: the extra [shop] is not installed.
        FileError: the folder does not exist or cannot be written to, the file is an input, or the default file exists
            and is no such report.
        GrindError: as in `machine.grind`.
    """
    from grind_env.shop.report.document import PAGE, SUFFIXES, prepare_page, write_page
    from grind_env.shop.report.run_report import run_report

    program = Path(program)
    written = beside(program, SUFFIXES[0]) if output is None else Path(output)
    path = job_beside(program) if job is None else Path(job)
    numbers = [each.program for each in interrupts_of(interrupts)]
    read = program, *called_files(program, numbers), *files_named(path)
    check_targets([Target(path=written, replaceable=PAGE if output is None else None)], read)
    prepare_page(written)
    programs, settings = read_file(program), load_job(path)
    record = grind_file(
        programs,
        settings,
        block_delete=block_delete,
        blocks=blocks,
        groove_retract=groove_retract,
        variables=variables,
        dress_at=dress_at,
        interrupts=interrupts,
        plant=plant,
    )
    write_page(written, run_report(record, (program, path)))
    return written


def optimise(
    program: File,
    job: File | Job | None = None,
    *,
    vary: Collection[str] | None = None,
    bounds: Mapping[str, Ends] = {},
    margin: Mapping[str, Number] = {},
    fix: Collection[int] = (),
    constraint: Mapping[str, Number] = {},
    objective: str = "cost",
    parts: int = 50,
    budget: Number = 60.0,
    programs: int | None = None,
    seed: int = 1,
    variables: Mapping[int, float] = {},
    plant: str | None = None,
    confidence: Number = CONFIDENCE,
    untried: bool = False,
) -> "Optimised":
    """Return a cheaper version of a program within the limits: other E and D, or other settings.

    Args:
        program: file of the part program.
        job: its job file, or a result of `load_job`; the search then uses its own machine. The program's name with
            `.toml` if None.
        vary: values to vary: E, D, J, L of cycle blocks, lead, depth, passes of dress programs, the dress interval;
            missing words are added. By default E and D where present, and the interval.
        bounds: lowest and highest value by word, in units of the program; of the interval in parts.
        margin: share of a limit that parts must keep, by name: power, rise, Ra, size.
        confidence: probability with which a part keeps each limit for any lot and machine, and with which each end of
            an interval holds.
        untried: whether the program has never run on the machine; else it is assumed to grind good parts there.
        fix: N words of the cycle blocks that stay unchanged.
        constraint: highest mean cost ($) or time (seconds) of a part, by name.
        objective: value to reduce, cost or time.
        parts: runs of the program in a batch; the wheel carries over.
        budget: time of search and judgement, s, without compilation.
        programs: number of programs to try instead of a time; the same seed then gives the same result.
        seed: seed of the lots and of the search.
        variables: values of # variables before the first part, as `{500: 0}`; common variables carry over.
        plant: name of the machine that judges the result (`grind_env.plants`); the job's if None. The search uses the
            model.

    Raises:
        CondemnedError: the model scraps the parts of the unchanged program, and `untried` is False.
        GrindError: the program cannot be run, it has nothing to vary, or an option has no legal value.
    """
    from grind_env.shop.optimise.optimisation import find_words

    seconds = seconds_of(budget)
    options = options_of(vary, bounds, fix, margin, objective, constraint, confidence=confidence, untried=untried)
    with progress(most=f"of {seconds:g} s" if programs is None else "") as advance:
        return find_words(
            program,
            job,
            options,
            parts=parts,
            seconds=seconds,
            programs=programs,
            seed=seed,
            variables=variables,
            plant=plant,
            progress=advance,
        )


def sweep(
    program: File,
    job: File | Job | None = None,
    *,
    E: Ends | None = None,
    dress_every: Ends | None = None,
    lead: Ends | None = None,
    depth: Ends | None = None,
    parts: int = 50,
    seed: int = 1,
    variables: Mapping[int, float] = {},
    untried: bool = False,
) -> "Sweep":
    """Return cost and margins of a part over E and dress interval, then over lead and depth of the dress.

    Args:
        program: file of the part program.
        job: its job file, or a result of `load_job`; the program's name with `.toml` if None.
        E: E of the first cycle block, mm/min; other blocks keep their ratio to it. Without any range: half to twice
            its value, and dress intervals 1 to 20.
        dress_every: dress intervals, in parts.
        lead: lead of the dress, mm a revolution of the wheel.
        depth: depth of the dress, mm a pass.
        parts: runs of the program in a batch; the wheel carries over.
        seed: seed of the lots.
        variables: values of # variables before the first part, as `{500: 0}`; common variables carry over.
        untried: whether the program has never run on the machine, as in `optimise`.

    Raises:
        GrindError: the program cannot be run with these values, or a range has no legal ends.
    """
    from grind_env.shop.sweep.study import SweepRanges
    from grind_env.shop.sweep.study import sweep as study

    given = {name: ends for name, ends in (("E", E), ("lead", lead), ("depth", depth)) if ends is not None}
    asked: dict[str, Any] = {name: tuple(map(float, ends_of(f"--{name}", name, each))) for name, each in given.items()}
    if dress_every is not None:
        asked["every"] = whole_ends_of("--dress-every", "intervals", dress_every)
    ranges = SweepRanges(**asked)
    with progress() as advance:
        return study(
            program, job, ranges, parts=parts, seed=seed, variables=variables, untried=untried, progress=advance
        )


def calibrate(
    log: File,
    job: File,
    *,
    program: File | None = None,
    gauge: File | None = None,
    map_file: File | None = None,
    fit: Collection[str] | None = None,
    report_stage: Callable[[str], None] = lambda stage: None,
) -> "Calibration":
    """Return the process model fitted to a log of the spindle's power, or to a table of settings.

    Args:
        log: file of the log, or of the table.
        job: job file of the machine and the parts in the log.
        program: part program that was logged; without it `log` is a table of settings.
        gauge: file of measurements of the parts, one row for each part.
        map_file: file that assigns columns to quantities, if their names do not.
        fit: constants to fit; None for all constants that the log determines.
        report_stage: function that is called with the name of each stage of the work.

    Raises:
        CalibrationError: nothing can be fitted; the message says why, and what to do.
        GrindError: a file cannot be used.
    """
    from grind_env.shop.calibrate.log_calibration import calibrate as from_log
    from grind_env.shop.calibrate.table_calibration import calibrate_table

    mapped, gauged = (None if file is None else Path(file) for file in (map_file, gauge))
    if program is None:
        return calibrate_table(Path(log), Path(job), map_file=mapped, names=fit, report_stage=report_stage)
    files = Path(log), Path(program), Path(job)
    return from_log(*files, gauge=gauged, map_file=mapped, names=fit, report_stage=report_stage)


def plan(program: File, job: File, output: File) -> str:
    """Write a program with several E, depths and one dress, whose log identifies the constants; return a description.

    Args:
        program: program to start from.
        job: its job file.
        output: the file to be written.

    Raises:
        CalibrationError: no plan can be made from the program.
        GrindError: program or job cannot be used, or the file cannot be written.
    """
    from grind_env.shop.calibrate.experiment_program import plan_of

    made = plan_of(read_file(Path(program)), load_job(Path(job)))
    write_atomically(Path(output), lambda temporary: temporary.write_text(made.text, encoding="utf-8"))
    return str(made)
