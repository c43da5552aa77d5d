"""E and D of the next block, at the machine."""

from pathlib import Path
from typing import Annotated

import typer

from grind_env.arguments import FILE, Writes
from grind_env.shop.advise.own import LOG, STATE, VALUES
from grind_env.shop.commands.arguments import BATCH, FirstVariables, JobFile, OtherPart, ProgramFile


def advise(
    program: ProgramFile,
    job: JobFile = None,
    policy: Annotated[
        str | None,
        typer.Option(
            help="By name, a constant such as E12D0, or a .safetensors file; after guarded: with the guard; "
            "guarded:look_ahead if not given."
        ),
        FILE,
    ] = None,
    other_part: OtherPart = False,
    parts: Annotated[int, typer.Option(help="Parts of the batch.")] = BATCH,
    variables: FirstVariables = None,
    by: Annotated[str, typer.Option(help="block or part: what a row of readings is of.")] = "block",
    measurements: Annotated[Path | None, typer.Option(help="CSV with a row for each block or part."), FILE] = None,
    follow: Annotated[bool, typer.Option("--follow", help="Wait for further rows of that file.")] = False,
    state: Annotated[
        Path | None,
        typer.Option(help="State; PROGRAM with .advise.json if not given. The log is the .csv file of its name."),
        Writes(usual=".advise.json", own=STATE, always=True, beside={".csv": LOG}),
    ] = None,
    write: Annotated[
        Path | None,
        typer.Option(
            help="Write E and D as #101=..., #102=... into this file before each block; one that holds anything else "
            "is not replaced."
        ),
        Writes(own=VALUES, always=True, called=True),
    ] = None,
    step: Annotated[
        float,
        typer.Option(
            help="Most that E is above the fastest tried of a kind of block, as a factor, of a policy with the guard."
        ),
    ] = 1.25,
    bounds: Annotated[
        tuple[float, float] | None, typer.Option(metavar="LOW HIGH", help="Lowest and highest E to advise, m/min.")
    ] = None,
    shadow: Annotated[
        bool,
        typer.Option(
            "--shadow",
            help="Look on: E and D are those of the program, or of the readings; in the end, or when you stop "
            "it, forecasts are printed beside readings.",
        ),
    ] = False,
    restart: Annotated[bool, typer.Option("--restart", help="Forget what the state has kept, and begin anew.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print advice as JSON objects, one a line.")] = False,
) -> None:
    """Advise at the machine: E and D of the next cycle block from what was measured of those before, with the reason.

    Readings are typed in, or come as JSON lines on standard input, or as rows of a CSV; all of them may be missing:
    mean_power, first_power, peak_power (W above idle), and of a finished part size_error, Ra, Ra_before (um), diameter
    (mm), new_lot, new_wheel (1 or 0); E and D where they were not the advised ones. It goes on where it was stopped,
    and logs everything into a CSV beside its state, with which one adviser at a time works.

    Readings that are not as they were forecast are an alarm, in words: until forecasts hold again, it advises what has
    worked on this machine. It begins at the words of the program, and E rises step by step. A reading that cannot be,
    such as 2.6 W for 2.6 kW, is refused with a sentence and awaited anew; with --measurements it has to be
    corrected in the file, and without --follow the session ends there, to be gone on with.
    """
    from grind_env.control.options import variables_of
    from grind_env.shop.advise.command import open_session
    from grind_env.shop.advise.state import held

    assert state is not None  # the usual name has been filled in
    with held(state):
        session = open_session(
            program,
            job,
            policy=policy,
            other_part=other_part,
            parts=parts,
            variables=variables_of(variables or ()),
            by=by,
            measurements=measurements,
            follow=follow,
            state=state,
            values=write,
            as_json=as_json,
            step=step,
            bounds=bounds,
            shadow=shadow,
        )
        if restart:
            session.begin()
        session.resume()
        session.run()
