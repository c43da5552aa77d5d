"""Arguments of several commands."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.file_arguments import JOB, PROGRAM, Requests, Writes

BATCH = 30  #: default number of parts of an advised batch

ProgramFile = Annotated[Path, typer.Argument(metavar="PROGRAM", help="Part program (.nc)."), PROGRAM]
JobFile = Annotated[Path | None, typer.Option("--job", help="Job file; default PROGRAM with .toml."), JOB]
Runs = Annotated[int, typer.Option(min=1, max=1000, help="Parts in your batches.")]
ReportFile = Annotated[Path | None, typer.Option("--report", help="Write a report to this .html file."), Writes()]
PlotFile = Annotated[
    Path | None, typer.Option("--plot", help="Write a figure to this .png, .svg or .pdf file."), Writes()
]
CsvFile = Annotated[Path | None, typer.Option("--csv", help="Write a table for spreadsheets to this file."), Writes()]
AsJson = Annotated[bool, typer.Option("--json", help="Print the result as one JSON object.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of the random numbers.")]
BlockDelete = Annotated[bool, typer.Option("--block-delete", help="Skip blocks that begin with '/'.")]
MaxBlocks = Annotated[int | None, typer.Option(help="Refuse more blocks and strokes than this; default 500000.")]
GrooveRetract = Annotated[float | None, typer.Option(help="Retract of G76 and G77, mm; default 0.5.")]
Variables = Annotated[list[str] | None, typer.Option("--set", help="Set a # variable: '#101=15000'; repeatable.")]
FirstVariables = Annotated[
    list[str] | None, typer.Option("--set", help="Set a G-code variable before the first part: '#500=0'.")
]
Plant = Annotated[str | None, typer.Option(help="For tests: another simulated machine: public:3.")]
OtherPart = Annotated[bool, typer.Option("--other-part", help="Accept an agent trained on another part.")]
Untried = Annotated[bool, typer.Option("--untried", help="The program never ran: keep machines that make scrap.")]
DressAt = Annotated[list[float] | None, typer.Option(help="The operator asks for a dress at this time, s; repeatable.")]
Interrupts = Annotated[
    list[str] | None, typer.Option("--interrupt", help="Call O9200 at 12.5 s: 9200@12.5; repeatable."), Requests()
]


def prepare_report(report: Path | None) -> None:
    """Check, before the work, that the page of `--report` can be written, if one is asked for."""
    from grind_env.shop.report.document import prepare_page

    if report is not None:
        prepare_page(report)
