"""Price of a policy: blocks of its training or tuning, knowledge of the simulator, and time of its decisions."""

import time
from pathlib import Path

import numpy as np

from agents.benchmark.plan import ON_BELIEF, PLAIN, BenchmarkCell
from grind_env.envs.actions import ActionCodec
from grind_env.envs.simulation import Simulation
from grind_env.policies.evaluation import done, episode_seeds, start_episodes
from grind_env.policies.policy import Policy
from grind_env.policies.privileged_information import reveal
from grind_env.policies.registry import REFERENCE
from grind_env.policies.tuned_parameters import read_tuned, tuned_folder

EPISODES = 16  #: number of validation episodes on which a decision is timed
#: policies that use the equations with nominal constants, to estimate or follow the wheel
NOMINAL = ("adaptive_rule", "belief_rule", "look_ahead", ON_BELIEF)
EXACT = ("mpc", REFERENCE)  #: policies that use the simulator with the true lot and wheel of the episode
RULE = {"mpc": "full_state_rule"}  #: tuned rule of a policy, if the rule has another name


def model_of(cell: BenchmarkCell) -> str:
    """Return a policy's knowledge of the simulator's equations: `none`, `nominal` or `exact`."""
    if cell.trains:
        return "none" if PLAIN.get(cell.base) == "gru" else "nominal"
    return "nominal" if cell.base in NOMINAL else "exact" if cell.base in EXACT else "none"


def tuned_on(policy: str, simulation: Simulation, configs: Path | None = None) -> int:
    """Return the number of blocks ground to tune a policy, without validation blocks; 0 for an untuned policy."""
    tuned = read_tuned(simulation.task.name, tuned_folder(simulation.task, configs)).get(RULE.get(policy, policy))
    return 0 if tuned is None else tuned.evaluations * tuned.training_seeds[1] * simulation.task.blocks


def decision_ms(policy: Policy, simulation: Simulation) -> float:
    """Return the measured CPU time of a decision of a policy, ms."""
    episodes = start_episodes(simulation, episode_seeds("validation", EPISODES))
    codec, decisions, seconds = ActionCodec(simulation.task), 0, 0.0
    policy.begin(simulation, EPISODES)
    while not (over := simulation.over(episodes)).all():
        shown = simulation.observe(episodes), reveal(policy.sees, simulation, episodes)
        begin = time.process_time()
        decision = policy.act(*shown)
        seconds += time.process_time() - begin
        going = np.flatnonzero(~over)
        decisions += len(going)
        simulation.step(episodes, *done(decision, simulation, codec, episodes), active=going)
    return 1e3 * seconds / decisions
