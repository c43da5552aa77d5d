"""The track as a study: adapters, machines, and estimated CPU time."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from agents.evaluation_cache import RESULTS
from agents.study import Found, Study, StudyOptions
from agents.track.adapter_registry import ADAPTERS, make_adapter
from agents.track.page import COLUMNS, RUN, page, rows
from agents.track.scale_anchors import SCALES, TRAINED, TRAININGS, MachineRuns
from agents.track.scores import ANCHORS, Anchors, Ground, anchors_of, collected, read_anchors, write_anchors
from agents.track.scores import COLUMNS as OF_ANCHORS
from agents.track.track_trials import TrackTrial, decides, run
from grind_env.errors import GrindError
from grind_env.plants import find_plants
from grind_env.policies.nominal_model import model_of
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.scoring import check_policy
from grind_env.policies.submitted_rows import track_row, write_rows
from grind_env.policies.track import BASELINE, MACHINES, TASK

POLICIES = ("plain_gru", "look_ahead", "empirical_rule", *ADAPTERS)  #: policies that run beside the anchors by default
#: first characters of each file
FILES = {"track.csv": ",".join(RUN), "track.md": "# The track", ANCHORS: ",".join(OF_ANCHORS)}
#: measured CPU time of a trial, s; trials of other adapters take about 1 s
SECONDS = {SCALES: 150.0, TRAINED: 105.0, "calibrated": 20.0, "robust_calibrated": 30.0}


def study(
    asked: StudyOptions, machines: Sequence[str] | None, adapters: Sequence[str] | None, submit: Path | None
) -> Study:
    """Return the study of policies on machines, by default the whole track.

    Frozen anchors of a machine stay unchanged. For other machines, the anchors are measured beside the adapters.
    """
    plants, names = list(dict.fromkeys(machines or MACHINES)), list(dict.fromkeys(adapters or POLICIES))
    for plant in plants:
        if not find_plants(plant, modules=True).one:
            raise GrindError(f"{plant!r} is the name of many machines: give a seed, as '{plant}:1'")
    model = model_of(find_problem(TASK))
    made = {name: make_adapter(name, model) for name in (BASELINE, *names)}
    for name, policy in made.items():
        check_policy(policy)
        if policy.sees != "measurements":
            raise GrindError(
                f"{name} sees the {policy.sees}, but the track shows measurements only: name another policy"
            )
    if submit is not None and (machines or adapters is None or len(names) != 1 or names[0] in ADAPTERS):
        raise GrindError("--submit writes the row of one policy on all machines: give --adapters once, no --machines")
    seeds = tuple(range(asked.seeds))
    frozen = read_anchors(RESULTS / ANCHORS, seeds)
    trials = []
    for plant in plants:
        beside = adapters is None or plant not in frozen
        if beside:
            trials.append(TrackTrial(plant, SCALES, seeds))
            trials += [TrackTrial(plant, TRAINED, seeds, k, asked.options.runs) for k in range(TRAININGS)]
        for name in dict.fromkeys((*[BASELINE] * beside, *names)):
            # a user's policy may have a memory, which must be of one run
            one_by_one = hasattr(made[name], "learn") or name not in (BASELINE, *POLICIES)
            trials += [TrackTrial(plant, name, of) for of in ([(seed,) for seed in seeds] if one_by_one else [seeds])]

    def prepare() -> None:
        for policy in made.values():
            policy.begin(model, 1)  # trains the agent of `rl2`, before trials run side by side

    def anchors(ground: Ground) -> Mapping[str, Anchors]:
        return {plant: frozen.get(plant) or anchors_of(runs) for plant, runs in ground.items()}

    def draw(found: Found, folder: Path) -> None:
        ground = ground_of(found)
        write_anchors(folder / ANCHORS, anchors(ground))
        if submit is not None:
            costs = [runs[Path(names[0]).name].runs.cost[0].mean() for runs in ground.values()]
            robust = [each.robust[0] for each in anchors(ground).values()]
            write_rows(submit, [track_row(names[0], np.array(costs), np.array(robust))])

    return Study(
        name="track",
        title="The track: machines that a policy does not know",
        trials=trials,
        run=run,
        decides=decides,
        prepare=prepare,
        seconds=lambda trial: SECONDS.get(trial.adapter, 1.0),
        columns=COLUMNS,
        rows=lambda found: rows(ground_of(found)),
        page=lambda found: page(ground_of(found), anchors(ground_of(found))),
        episodes=asked.seeds,
        draw=draw,
        files=FILES,
    )


def ground_of(found: Found) -> Ground:
    """Return the cached results of trials by machine and name."""
    return collected(
        {trial: {name: MachineRuns.read(each) for name, each in runs.items()} for trial, runs in found.items()}
    )
