"""`grind advise`: E and D of the next block, at the machine."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.file_arguments import FILE, Writes
from grind_env.shop.advise.file_kinds import LOG, STATE, VALUES
from grind_env.shop.commands.arguments import BATCH, FirstVariables, JobFile, OtherPart, Plant, ProgramFile


def advise(
    program: ProgramFile,
    job: JobFile = None,
    policy: Annotated[str | None, typer.Option(help="Agent file, E12000D0 or module:Name as adviser."), FILE] = None,
    other_part: OtherPart = False,
    parts: Annotated[int, typer.Option(help="Parts in a batch.")] = BATCH,
    variables: FirstVariables = None,
    rows: Annotated[
        str, typer.Option(help="A row for each block, or for each part (power of its last block).")
    ] = "block",
    measurements: Annotated[Path | None, typer.Option(help="Readings (.csv), a row a block or part."), FILE] = None,
    follow: Annotated[bool, typer.Option("--follow", help="Wait for further rows of the file.")] = False,
    plant: Plant = None,
    state: Annotated[
        Path | None,
        typer.Option(help="File of the session; default PROGRAM with .advise.json."),
        Writes(default_suffix=".advise.json", replaceable=STATE, always=True, beside={".csv": LOG}),
    ] = None,
    write: Annotated[
        Path | None,
        typer.Option(help="Write E and D as #101=... to this file."),
        Writes(replaceable=VALUES, always=True, may_be_input=True),
    ] = None,
    max_step: Annotated[float, typer.Option(help="Largest usual rise of E, a factor.")] = 1.25,
    bounds: Annotated[
        tuple[float, float] | None, typer.Option(metavar="LOW HIGH", help="Range of E, mm/min; default 3000 30000.")
    ] = None,
    shadow: Annotated[bool, typer.Option("--shadow", help="You choose; only compare forecasts.")] = False,
    restart: Annotated[bool, typer.Option("--restart", help="Start a new session.")] = False,
    explain: Annotated[bool, typer.Option("--explain", help="Print the reasons of each advice.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON objects, one a line.")] = False,
) -> None:
    """Recommend E and D of the next block from measurements.

    Readings of a block: peak_power, mean_power, first_power (W above idle); E, D if not as advised.
    Of a part: size_error, Ra, Ra_before (um), burn, new_lot. Of the wheel: diameter (mm), new_wheel.
    A stopped session resumes. See docs/howto/advise.md.
    """
    from grind_env.control.cli_options import variables_of
    from grind_env.shop.advise.session_setup import AdviceRequest, open_session, rehearse
    from grind_env.shop.advise.state import locked_state

    assert state is not None  # the default name has been filled in
    request = AdviceRequest(
        program=program,
        job=job,
        policy=policy,
        other_part=other_part,
        parts=parts,
        variables=variables_of(variables or ()),
        step=max_step,
        bounds=bounds,
        as_json=as_json,
        why=explain,
    )
    if plant is not None:
        others = {"--measurements": measurements, "--write": write, "--shadow": shadow, "--restart": restart}
        rehearse(request, plant, [name for name, value in others.items() if value])
        return
    with locked_state(state):
        session = open_session(
            request, by=rows, measurements=measurements, follow=follow, state=state, values=write, shadow=shadow
        )
        if restart:
            session.begin()
        session.resume()
        session.run()
