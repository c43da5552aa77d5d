"""Policies that hold the model of a task, on machines on which one constant of it is another one."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from rich.console import Console

from agents.cells import RESULTS, RUNS, behaviour, fingerprint_of, sources
from agents.findings import keep, kept
from agents.pool import find_all
from agents.provenance import provenance
from agents.tables import check_tables, csv_of
from grind_env.envs.simulation import Simulation
from grind_env.pages.markdown import table
from grind_env.policies.evaluation import Evaluation, episode_seeds, run_seeds
from grind_env.policies.naming import named_policy
from grind_env.policies.problem import Problem
from grind_env.policies.scripted.rules import Fixed
from grind_env.policies.tuned import write_whole

FORCES = ("u_ch", "kp", "kc", "pm")
"""Specific energy of chips, ploughing pressure, normal over tangential force and pressure on wear flats."""
NOMINAL = "nominal"
WORLDS: Mapping[str, Mapping[str, float]] = {
    NOMINAL: {},
    "forces x 1.35": dict.fromkeys(FORCES, 1.35),
    "forces x 0.75": dict.fromkeys(FORCES, 0.75),
    "stiffness / 4": {"ke": 0.25},
    "dulling x 3": {"kA": 3.0},
    "coolant x 0.4": {"hf": 0.4},
    "roughness x 1.3": {"RaRef": 1.3},
}
"""Factors on symbols of the process model, by the name of the machine."""
RETUNED, RULE, SHIPPED, GUARDED, ROBUST = "retuned plan", "empirical_rule", "shipped", "guarded:shipped", "robust"
WHO = (RETUNED, RULE, SHIPPED, GUARDED, ROBUST)
SPEEDS, DRESSES = (3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 13.0), ((1, 1), (2, 1), (3, 1), (1, 2), (1, 4))
"""Fixed plans of which the best on a machine is taken: E, m/min, and D with the interval in blocks."""
VALIDATED = 64
"""Validation episodes on which it is chosen."""
OVER_BEST, OVER_SHIPPED = 1.15, 1.03
"""What is asked of the guard: over the cheaper one of agent and rule on every machine, over the agent on the model."""
CSV, PAGE, TITLE = "worlds.csv", "worlds.md", "# The guard on machines with another constant"
COLUMNS = ("world", "who", "cost", "low", "high", "scrap")
BEGINS = {CSV: ",".join(COLUMNS), PAGE: TITLE}

Found = Mapping[str, float]


class Cell(NamedTuple):
    """A policy on a machine."""

    problem: Problem
    world: str
    who: str

    def __str__(self) -> str:
        return f"{self.who}: {self.world}"

    @property
    def files(self) -> tuple[str, ...]:
        """What is kept of it."""
        name = "-".join("".join(c if c.isalnum() else "_" for c in each) for each in (self.world, self.who))
        return (f"worlds/{self.problem.name}/{name}.json",)

    @property
    def trains(self) -> bool:
        """No agent is trained."""
        return False


class Request(NamedTuple):
    """How cells are worked on."""

    episodes: int
    """Evaluation episodes."""
    runs: Path
    """Folder of what is kept."""

    @property
    def size(self) -> int:
        """A cell tells nothing on the way."""
        return 1


def machine_of(model: Simulation, factors: Mapping[str, float]) -> Simulation:
    """The machine on which constants are so many times those of a model."""
    made: Any = model
    machine: Simulation = type(made)(replace(made.task, factors={**made.task.factors, **factors}))
    return machine


def work(cell: Cell, request: Request, tell: Callable[[int], object]) -> Found:
    """What a good part costs, $, with its 95 %, and the share of scrap."""
    model = cell.problem.simulation()
    machine, path = machine_of(model, WORLDS[cell.world]), request.runs / cell.files[0]
    policy = None if cell.who == RETUNED else named_policy(cell.who, model)
    made_of = "" if policy is None else fingerprint_of(policy, model)
    decides = (sources(__name__), made_of, behaviour(model), behaviour(machine), request.episodes)
    code = hashlib.sha256("\0".join(map(str, decides)).encode()).hexdigest()[:16]
    if (held := kept(path, code)) is not None:
        return dict(held)
    seeds = episode_seeds("evaluation", request.episodes)
    run = run_seeds(_retuned(machine) if policy is None else policy, machine, seeds, model=model)
    cost = run.cost_per_good_part
    found = {"cost": cost.value, "low": cost.low, "high": cost.high, "scrap": run.scrap}
    tell(1)
    return dict(keep(path, code, found))


def _retuned(machine: Simulation) -> Fixed:
    """The fixed plan that is best there."""
    seeds = episode_seeds("validation", VALIDATED)
    plans = [Fixed(E, *dresses) for E, dresses in product(SPEEDS, DRESSES)]

    def cost(plan: Fixed) -> float:
        run: Evaluation = run_seeds(plan, machine, seeds)
        return run.cost_per_good_part.value

    return min(plans, key=cost)


def run_worlds(
    problem: Problem,
    episodes: int,
    *,
    jobs: int,
    console: Console,
    runs: Path = RUNS,
    results: Path = RESULTS,
) -> dict[tuple[str, str], Found]:
    """Run every policy on every machine, and write the table.

    Args:
        problem: whose model the policies hold.
        episodes: evaluation episodes.
        jobs: processes.
        console: shows how far it is.
        runs: folder of what is kept, in its sub-folder `worlds`.
        results: folder of the table.

    Raises:
        FileError: another table has the name of one that is to be written.
        GrindError: a cell failed.
    """
    results.mkdir(parents=True, exist_ok=True)
    check_tables(results, "worlds", BEGINS)
    cells = [Cell(problem, world, who) for world in WORLDS for who in WHO]
    found = find_all(cells, Request(episodes, runs), jobs, console, work)
    by_cell = {(cell.world, cell.who): each for cell, each in zip(cells, found, strict=True)}
    made_with = provenance(episode_seeds("evaluation", episodes))
    rows = [(*of, *(each[name] for name in COLUMNS[2:]), *made_with.values()) for of, each in by_cell.items()]
    text = csv_of([*COLUMNS, *made_with], rows)
    for name, content in ((CSV, text), (PAGE, page(by_cell, problem.name, episodes))):
        write_whole(results / name, content)
    return by_cell


def promises(found: Mapping[tuple[str, str], Found]) -> list[tuple[str, float, float]]:
    """What is asked of the guard: what, what was found, and what it may be at most."""

    def over(world: str, others: Sequence[str]) -> float:
        return found[world, GUARDED]["cost"] / min(found[world, who]["cost"] for who in others)

    return [
        (
            "guarded over the cheaper one of agent and rule, worst",
            max(over(w, (SHIPPED, RULE)) for w in WORLDS),
            OVER_BEST,
        ),
        ("guarded over the agent, nominal", over(NOMINAL, (SHIPPED,)), OVER_SHIPPED),
    ]


def page(found: Mapping[tuple[str, str], Found], task: str, episodes: int) -> str:
    """The table, Markdown."""
    rows = []
    for world in WORLDS:
        cells = [found[world, who] for who in WHO]
        costs = (f"{each['cost']:.2f} ({each['low']:.2f} to {each['high']:.2f})" for each in cells)
        rows.append((world, *costs, f"{100.0 * found[world, GUARDED]['scrap']:.1f}"))
    asked = [
        (what, f"{value:.3f}", f"at most {most:g}", "yes" if value <= most else "NO")
        for what, value, most in promises(found)
    ]
    return (
        f"{TITLE}\n\n`python -m agents worlds`: $ per good part (95 %) on `{task}`, {episodes} evaluation episodes, on"
        " machines on which constants of the process are so many times those of the model that the policies hold. The"
        f" *retuned plan* is the best of {len(SPEEDS) * len(DRESSES)} fixed plans there, on {VALIDATED} validation"
        " episodes; *robust* holds no model.\n\n"
        + table(("machine", *WHO, "scrap of guarded:shipped, %"), rows)
        + "\n\n"
        + table(("what", "found", "asked", "kept"), asked)
        + "\n"
    )
