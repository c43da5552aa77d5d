"""`grind` commands for a user's programs, jobs and logs, a module for each; `setup_commands.py` has the first ones."""

from collections.abc import Callable

from grind_env.shop.commands.advise import advise
from grind_env.shop.commands.calibrate import calibrate
from grind_env.shop.commands.optimise import optimise
from grind_env.shop.commands.report import report
from grind_env.shop.commands.setup_commands import catalogue, doctor, init, job, warm_up
from grind_env.shop.commands.sweep import sweep

EXAMPLES: dict[Callable[..., None], tuple[str, ...]] = {
    init: ("grind init my_part", "grind init rail && grind run rail/part.nc"),
    job: ("grind job --template", "grind job --template > plate.toml"),
    catalogue: ("grind catalogue wheel a60j", "grind catalogue --file shop.toml --json"),
    report: ("grind report plate.nc", "grind report plate.nc --job steel.toml -o steel.html"),
    optimise: ("grind optimise plate.nc -o better.nc", "grind optimise plate.nc --vary E,D,J --margin power=.85"),
    sweep: ("grind sweep plate.nc --plot plate.png", "grind sweep plate.nc --E 8000..24000 --dress-every 1..20"),
    advise: ("grind advise plate.nc --measurements measured.csv --follow", "grind advise plate.nc --plant public:3"),
    calibrate: (
        "grind calibrate log.csv --program plate.nc --job plate.toml -o fitted.toml",
        "grind calibrate settings.csv --job plate.toml --report fit.html",
    ),
    warm_up: ("grind warm-up", "NUMBA_CACHE_DIR=/shared/cache grind warm-up"),
    doctor: ("grind doctor", "grind doctor --json"),
}
