"""The commands of `grind` for one's own programs, jobs and logs, a module for each; `start.py` has the first ones."""

import typer

from grind_env.shop.commands.advise import advise
from grind_env.shop.commands.calibrate import calibrate
from grind_env.shop.commands.doctor import doctor, warm_up
from grind_env.shop.commands.optimise import optimise
from grind_env.shop.commands.report import report
from grind_env.shop.commands.start import catalogue, init, job
from grind_env.shop.commands.sweep import sweep


def register(app: typer.Typer) -> None:
    """Add the commands to the application."""
    app.command(epilog="Example: grind init my_part")(init)
    app.command(epilog="Example: grind job --template > plate.toml")(job)
    app.command(epilog="Example: grind catalogue wheel a60j")(catalogue)
    app.command(epilog="Example: grind report plate.nc --job plate.toml -o plate.html")(report)
    app.command(epilog="Example: grind optimise plate.nc --vary E,D,J --margin power=.85 -o plate_opt.nc")(optimise)
    app.command(epilog="Example: grind sweep plate.nc --E 8000..24000 --dress-every 1..20 --plot plate.png")(sweep)
    app.command(epilog="Example: grind advise plate.nc --parts 30 --measurements measured.csv --follow")(advise)
    app.command(
        epilog="Example: grind calibrate log.csv --program plate.nc --job plate.toml --gauge parts.csv -o shop.toml"
    )(calibrate)
    app.command(epilog="Example: grind warm-up")(warm_up)
    app.command(epilog="Example: grind doctor")(doctor)
