"""What a program does, as one HTML file."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.shop.commands.arguments import JobFile, ProgramFile


def report(
    program: ProgramFile,
    job: JobFile = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The .html file; PROGRAM with .html if not given.")
    ] = None,
    block_delete: Annotated[bool, typer.Option("--block-delete", help="Skip blocks that begin with '/'.")] = False,
) -> None:
    """Grind with a program as `grind run` does, and write it up as one HTML file that works offline and prints on A4.

    Verdict, margin to each limit, a table of the blocks, plots, parts, dresses, cost, warnings, the program with
    remarks, and what the numbers rest on. Needs the extra [shop].
    """
    from dataclasses import replace

    from grind_env import control
    from grind_env.errors import printable
    from grind_env.machine.grind import grind
    from grind_env.machine.job_file import job_beside, load_job
    from grind_env.shop.report.document import prepare_page, write_page
    from grind_env.shop.report.run import run_report

    written = program.with_suffix(".html") if output is None else output
    prepare_page(written)
    path = job_beside(program) if job is None else job
    programs, settings = control.read_file(program), load_job(path)
    record = grind(programs, settings, control=replace(settings.control, block_delete=block_delete))
    write_page(written, run_report(record, programs, settings, (program, path)))
    print(printable(f"written: {written}"))
