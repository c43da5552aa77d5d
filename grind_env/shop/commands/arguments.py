"""What several commands are given."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.arguments import JOB, PROGRAM, Asked, Writes

BATCH = 30
"""Parts of a batch that is advised on, if their number is not given."""

ProgramFile = Annotated[Path, typer.Argument(metavar="PROGRAM", help="Part program, a text file."), PROGRAM]
JobFile = Annotated[Path | None, typer.Option("--job", help="Job file; PROGRAM with .toml if not given."), JOB]
Runs = Annotated[int, typer.Option(min=1, max=1000, help="Runs of the program in a batch; the wheel carries over.")]
ReportFile = Annotated[Path | None, typer.Option("--report", help="Write the result up as this .html file."), Writes()]
Seed = Annotated[int, typer.Option(min=0, help="Of lots and search; the same seed finds the same.")]
BlockDelete = Annotated[bool, typer.Option("--block-delete", help="Skip blocks that begin with '/'.")]
Blocks = Annotated[
    int | None, typer.Option(help="Most blocks and strokes that the program may execute; if not given, 500000.")
]
GrooveRetract = Annotated[
    float | None,
    typer.Option(help="Retract amount of G76 and G77, mm; if not given, 0.5 mm, or 0.02 in under G70."),
]
Variables = Annotated[
    list[str] | None,
    typer.Option("--set", help="Value of a # variable at the start, such as '#101=15000'; repeatable."),
]
FirstVariables = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        help="Value of a # variable before the first part, such as '#500=0'; repeatable.",
    ),
]
Plant = Annotated[
    str | None,
    typer.Option(
        help="Machine that is not the model: meter:7, foreign:3+meter:7, held-out:5, module:name; by default what "
        "the job says."
    ),
]
OtherPart = Annotated[
    bool, typer.Option("--other-part", help="Accept an agent that was trained for another part; a first line says so.")
]
Untried = Annotated[
    bool, typer.Option("--untried", help="The program has not ground good parts on this machine so far.")
]
DressAt = Annotated[
    list[float] | None,
    typer.Option(
        help="The operator asks for a dress at this time, s on the clock of the control, which counts no loading or "
        "set-up; repeatable."
    ),
]
Interrupts = Annotated[
    list[str] | None,
    typer.Option(
        "--interrupt",
        help="The operator asks for a program in between, as in 9200@12.5: O9200 at 12.5 s on that clock, after which "
        "the axes return to where they were. 9200@12.5:1 is type 1, which goes on from where O9200 ends; repeatable.",
    ),
    Asked(),
]


def prepare_report(report: Path | None) -> None:
    """Find out, before the work, whether the page of `--report` can be written, if one is asked for.

    Raises:
        GrindError: as of `prepare_page`.
    """
    from grind_env.shop.report.document import prepare_page

    if report is not None:
        prepare_page(report)
