"""The track: which adapters are run on which machines, and how long that takes."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace

from agents.benchmark.plan import chosen_problems
from agents.study import Found, Study, StudyOptions
from agents.track.adapters import BLOCKS, HEADLINE, WIDE, made
from agents.track.knowing import ANCHORS, KNOWING
from agents.track.page import COLUMNS, page, rows
from agents.track.running import TUNING, TrackRun, TrackTrial, decides, find, tuning_of
from grind_env.errors import GrindError, quoted
from grind_env.plants import find_plants
from grind_env.policies.problem import Problem, find_problem

TASK, WIDE_TASK = "power_limited", "wide_rails"
MACHINES, WIDE_MACHINES, SEEDS = 20, 8, 3
WIDE_BLOCKS = (0, 300)
TUNING_SECONDS, SHIFT, JUDGING = 100.0, 0.3, 8.0
"""CPU-seconds, by measurement: of tuning on a machine, and at most of a shift and of judging once."""


def cells_of(
    problem: Problem, plants: Sequence[str], adapters: Sequence[str], blocks: tuple[int, ...], seeds: int, episodes: int
) -> list[TrackTrial]:
    """Runs of adapters, and those of the anchors, machine by machine, so that what grinds is compiled once."""
    names = dict.fromkeys((*ANCHORS, *adapters))
    return [
        TrackTrial(problem, plant, name, seed, blocks, episodes)
        for plant in plants
        for name in names
        for seed in range(seeds)
    ]


def held_out(count: int) -> tuple[str, ...]:
    """Names of the first machines that are held out."""
    return tuple(f"held-out:{seed}" for seed in range(1, count + 1))


def whole_track(seeds: int, episodes: int, *, wide: bool) -> list[TrackTrial]:
    """The headline on 20 machines; if `wide`, more adapters, and all on another task, on 8 of these."""
    task, other, few = find_problem(TASK), find_problem(WIDE_TASK), held_out(WIDE_MACHINES)
    cells = cells_of(task, held_out(MACHINES), HEADLINE, BLOCKS, seeds, episodes)
    if wide:
        cells += cells_of(task, few, WIDE, BLOCKS, seeds, episodes)
        cells += cells_of(other, few, (*HEADLINE, *WIDE), WIDE_BLOCKS, seeds, episodes)
    return list(dict.fromkeys(cells))


def study(
    asked: StudyOptions, machines: Sequence[str] | None, adapters: Sequence[str] | None, blocks: str | None, wide: bool
) -> Study:
    """Tune on every machine that somebody asks for, by default those of the whole track, and return the study."""
    if asked.tasks or machines or adapters or blocks:
        problems = chosen_problems(asked.tasks or TASK, asked.job, asked.parts)
        cells = cells_asked(problems, machines or (), adapters or (), blocks, asked, wide=wide)
    else:
        cells = whole_track(asked.seeds, asked.episodes, wide=wide)
    before = _study(list(dict.fromkeys(map(tuning_of, cells))))
    before.check(asked.results)
    known = {cell: json.dumps(found) for cell, found in before.found(asked.options).items()}
    return _study([replace(cell, tuned=known[tuning_of(cell)] * (cell.adapter in KNOWING)) for cell in cells])


def cells_asked(
    problems: Sequence[Problem],
    machines: Sequence[str],
    adapters: Sequence[str],
    blocks: str | None,
    asked: StudyOptions,
    *,
    wide: bool,
) -> list[TrackTrial]:
    """The cells that somebody asks for."""
    plants = [name for each in machines for name in (held_out(int(each)) if each.isdecimal() else [each])]
    for name in plants:
        if not find_plants(name, modules=True).one:
            raise GrindError(f"{name!r} is the name of many machines: give a seed, as '{name}:1'")
    names, cells = adapters or ((*HEADLINE, *WIDE) if wide else HEADLINE), list[TrackTrial]()
    for problem in problems:
        for name in adapters:
            if name not in KNOWING:
                made(name).start(problem)
        usual = BLOCKS if problem.name == TASK else WIDE_BLOCKS
        chosen = usual if blocks is None else check_blocks(problem, blocks)
        cells += cells_of(problem, plants or held_out(MACHINES), names, chosen, asked.seeds, asked.episodes)
    return cells


def check_blocks(problem: Problem, text: str) -> tuple[int, ...]:
    """Return blocks on a machine, ascending, of numbers with commas between them: whole shifts."""
    shift = problem.simulation().task.blocks
    for number in text.split(","):
        if not number.strip().isdecimal() or int(number) % shift:
            raise GrindError(
                f"--blocks has {quoted(number)}, but a shift of {problem.name} has {shift}: give multiples"
            )
    return tuple(sorted({int(number) for number in text.split(",")}))


def _study(cells: Sequence[TrackTrial]) -> Study:
    def runs(found: Found) -> Mapping[TrackTrial, TrackRun]:
        return {cell: TrackRun(**each) for cell, each in found.items()}

    return Study(
        name="track",
        title="The track plants",
        trials=cells,
        run=find,
        decides=decides,
        seconds=seconds,
        columns=COLUMNS,
        rows=lambda found: rows(runs(found)),
        page=lambda found: page(runs(found)),
        episodes=(1 + max(cell.seed for cell in cells)) * max(cell.episodes for cell in cells),
    )


def seconds(cell: TrackTrial) -> float:
    """CPU-seconds that a cell takes at most, by measurement."""
    if cell.adapter == TUNING:
        return TUNING_SECONDS
    return SHIFT * cell.blocks[-1] / cell.problem.simulation().task.blocks + JUDGING * len(cell.blocks)
