"""A policy followed block by block: its choice, the true state, the belief, and the choices of other policies."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from grind_env.array_types import Array
from grind_env.belief.filter_quantities import Belief
from grind_env.belief.wheel_belief import WheelBelief
from grind_env.envs.actions import ActionCodec
from grind_env.envs.distribution_splits import EVERY
from grind_env.envs.filter_members import MemberModel
from grind_env.errors import GrindError
from grind_env.message_text import quoted
from grind_env.optional_libraries import needing
from grind_env.policies.choices import Decision
from grind_env.policies.episode_columns import AREA, CHANGES, COST, OF_WHEEL
from grind_env.policies.evaluation import done, episode_seeds, start_episodes
from grind_env.policies.nominal_model import model_beside, parted
from grind_env.policies.policy import Policy
from grind_env.policies.policy_lookup import named_policy
from grind_env.policies.privileged_information import reveal
from grind_env.policies.problem_lookup import Problem, find_problem


@dataclass(frozen=True, slots=True, kw_only=True)
class Followed:
    """Episodes of a policy, block by block; all arrays have shape (N, blocks), NaN after the end of a shorter one."""

    chosen: Decision  #: chosen E, mm/min, and D
    beside: Mapping[str, Decision]  #: E and D of other policies in the same states, by name
    wear_flat: Array  #: true wear-flat area A before the block, fraction of the wheel surface
    dulling: Array  #: log of the true factor of wheel and lot on the dulling rate
    belief: Belief  #: belief of an ensemble filter before the block
    cost: Array  #: cost of the block, $

    def to_dataframe(self) -> Any:
        """Return a pandas data frame with a row for each block of each episode; columns have their units.

        Raises:
            MissingExtra: pandas is not installed.
        """
        with needing("data", "data frames need"):
            import pandas
        episode, block = np.indices(self.cost.shape)
        columns = {"episode": episode, "block": block + 1} | _decision("", self.chosen)
        columns |= {
            "wear-flat area": self.wear_flat,
            "dulling rate [ln]": self.dulling,
            "believed wear-flat area": self.belief.wear_flat,
            "its spread": self.belief.wear_flat_spread,
            "believed dulling rate [ln]": self.belief.growth,
            "cost [$]": self.cost,
        }
        for name, decision in self.beside.items():
            columns |= _decision(f" of {name}", decision)
        frame = pandas.DataFrame({name: values.ravel() for name, values in columns.items()})
        return frame.dropna(subset="cost [$]", ignore_index=True)


def follow(
    policy: Policy | str,
    problem: Problem | str,
    *,
    beside: Sequence[Policy | str] = (),
    seeds: str = "evaluation",
    split: str = EVERY,
    episodes: int = 64,
) -> Followed:
    """Run a policy through episodes and record every block.

    The policies in `beside` choose in each state, too, but their choices are not ground. Each policy sees the
    information that it declares. On an out-of-model machine, all policies and the belief compute with the model.

    Args:
        policy: the policy, or a text for `named_policy`: a name, a file, a constant.
        problem: the problem, or a text for `find_problem`: an id, a task file, a part program.
        beside: other policies, in the same forms.
        seeds: one of `evaluation.SEEDS`.
        split: split of the contexts, one of `grind_env.envs.distribution_splits.SPLITS`.
        episodes: number of episodes.

    Raises:
        GrindError: there is no such problem, policy or split, there are no such seeds, or two policies beside it have
            the same name.
        ActionError: the policy decides an E or a D that the environment does not have.
        BeliefError: the steps of the problem are not compiled blocks, which the belief needs.
    """
    problem = problem if isinstance(problem, Problem) else find_problem(problem)
    simulation, model = problem.simulation(), model_beside(problem)
    held = model or simulation
    all_of_them = [named_policy(each, held) if isinstance(each, str) else each for each in (policy, *beside)]
    twice = [name for name, count in Counter(each.name for each in all_of_them[1:]).items() if count > 1]
    if twice:
        raise GrindError(f"several policies beside it are called {quoted(twice[0])}; give each a name of its own")
    state = start_episodes(simulation, episode_seeds(seeds, episodes), split)
    filtered = WheelBelief(MemberModel(held))
    filtered.begin(episodes)
    for each in all_of_them:
        each.begin(held, episodes)
    views = [parted(each, simulation, model, state) for each in all_of_them]
    codec = ActionCodec(simulation.task)
    rows: list[list[Array]] = []
    while (running := np.flatnonzero(~simulation.over(state))).size > 0:
        seen = simulation.observe(state)
        said = [
            each.act(seen, reveal(each.sees, held, shown(state)))
            for each, shown in zip(all_of_them, views, strict=True)
        ]
        coming = state.coming()
        first, later = OF_WHEEL[0]
        dulling = np.log(np.where(state.memory[:, CHANGES] > 0.0, coming[:, later], coming[:, first]))
        before = [state.wheels[:, AREA].copy(), dulling, *filtered.update(seen)]
        chosen = Decision(*done(said[0], simulation, codec, state))
        outcomes, _ = simulation.step(state, *chosen, active=running)
        row = [*(values for decision in (chosen, *said[1:]) for values in decision), *before, outcomes[:, COST]]
        over = np.ones(episodes, bool)
        over[running] = False
        rows.append([np.where(over, np.nan, values) for values in row])
    table = list(np.array(rows).transpose(1, 2, 0))
    decisions = [Decision(*table[2 * k : 2 * k + 2]) for k in range(len(all_of_them))]
    wear_flat, dulling, *believed, cost = table[2 * len(all_of_them) :]
    return Followed(
        chosen=decisions[0],
        beside={each.name: said for each, said in zip(all_of_them[1:], decisions[1:], strict=True)},
        wear_flat=wear_flat,
        dulling=dulling,
        belief=Belief(*believed),
        cost=cost,
    )


def _decision(whose: str, decision: Decision) -> dict[str, Array]:
    return {f"E{whose} [mm/min]": decision.speeds, f"D{whose}": decision.executions}
