"""Whether a row holds: its actions replayed, and its policy run on episodes that nobody knew when it was written."""

import hashlib
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from grind_env.envs.actions import ActionError
from grind_env.envs.episodes import Episodes
from grind_env.envs.machines import machines_of
from grind_env.envs.simulation import Simulation
from grind_env.errors import quoted
from grind_env.plants.names import modules_of
from grind_env.policies.choices import Decision
from grind_env.policies.evaluation import run_seeds
from grind_env.policies.held import on
from grind_env.policies.policy import Sees
from grind_env.policies.rows.apart import apart
from grind_env.policies.rows.form import RowError
from grind_env.policies.rows.making import unpacked
from grind_env.policies.rows.row import Row, stated
from grind_env.policies.statistics import prediction

FRESH = 62
"""Bit of all seeds that are drawn, and number of the bits below: no frozen seed has as many."""
MOST_BLOCKS = 5_000_000
"""Blocks of all episodes: a stranger's row could ask for more memory than there is."""
NEAR = 1e-9
"""Share by which stated means may be off; costs of episodes are equal."""

Status = Literal["", "replayed", "measured-only"]


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a row holds: what it counts as, nothing if it does not hold, and what was found."""

    status: Status
    found: str


def fresh_seeds(seed: int, count: int) -> list[int]:
    """Seeds drawn from a number: 2^62 and the first 62 bits of SHA-256 of `grind verify NUMBER K`, K from 0 on.

    Example:
        >>> from grind_env.policies.rows.verifying import fresh_seeds
        >>> fresh_seeds(31415926535897932384, 2)
        [6086689464190250195, 8396082053851940109]
    """
    digests = [hashlib.sha256(f"grind verify {seed} {k}".encode()).digest() for k in range(count)]
    return [(1 << FRESH) + (int.from_bytes(each[:8], "big") >> 64 - FRESH) for each in digests]


def verify(row: Row, *, seed: int | None = None, episodes: int | None = None, trust: bool = False) -> Verdict:
    """Replay the actions of a row; with a seed, run its policy, too.

    Args:
        row: may be of anybody.
        seed: from which `fresh_seeds` are drawn: one that nobody can have guessed, such as of 20 digits.
        episodes: how many; by default as many as the row has.
        trust: whether modules of the row are run, of its policy or plant.

    Raises:
        RowError: it cannot be run: a text or an action of it is faulty, or a module is not trusted.
        GrindError: there is no such problem, split, plant or policy.
    """
    acting = [*modules_of(row.model), *([row.module] if row.module else [])] if seed is not None else []
    modules = [*modules_of(row.plant), *acting]
    if modules and not trust:
        raise RowError(f"it runs the code of its {modules[0]}.py: read that, and give --trust if it does no harm")
    if missing := [name for name in modules if f"{name}.py" not in row.files]:
        raise RowError(f"files has no {missing[0]}.py, whose code it runs: submit it again")
    with unpacked(row, modules_of(row.plant)) as (problem, _):
        simulation = (on(problem, row.plant) if row.plant else problem).simulation()
        machines = machines_of(simulation)
        if (machines.text if machines else "") != row.plant or bool(row.plant) != bool(row.model):
            raise RowError(f"plant is {quoted(row.plant)}, which does not fit its problem or model: submit it again")
        count = max(len(row.episodes), episodes or 0)
        if count * simulation.task.blocks > MOST_BLOCKS:
            raise RowError(
                f"{count} episodes of {simulation.task.blocks} blocks are more than {MOST_BLOCKS} blocks in all"
            )
        if fault := _fault(row, simulation):
            return Verdict("", fault)
        replayed = f"replayed: all {len(row.episodes)} episodes cost what it says, to the bit"
        if seed is None:
            return Verdict("replayed", replayed)
        if row.sees != "measurements" or not row.says:
            why = f"sees the {row.sees}" if row.says else "is not in it"
            return Verdict("", f"{replayed}\nnot measured-only: its policy {why}")
        seeds = fresh_seeds(seed, episodes or len(row.episodes))
        with apart(row, modules) as policy:
            mean = float(run_seeds(policy, simulation, seeds, row.split).cost.mean())
    _, low, high = prediction(np.array([each.cost for each in row.episodes]), len(seeds))
    status: Status = "measured-only" if low <= mean <= high else ""
    found = f"{len(seeds)} other episodes cost {mean:.4g} $ each, and {low:.4g} to {high:.4g} $ are predicted"
    return Verdict(status, f"{replayed}\n{status or 'not measured-only'}: {found}")


@dataclass
class _Recorded:
    """Does what the row says; where an episode has no more steps, its last action, which is not to be asked for."""

    row: Row
    name: str = "row"
    sees: Sees = "measurements"
    step: int = 0

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.step = 0

    def act(self, observation: NDArray[np.float32], episodes: Episodes | None) -> Decision:
        said = [(each.E[k], each.D[k]) for each in self.row.episodes for k in [min(self.step, len(each.E) - 1)]]
        self.step += 1
        return Decision(*np.array(said).T)


def _fault(row: Row, simulation: Simulation) -> str:
    """What of the episodes does not hold, in a sentence; nothing if all does. Actions that are none are refused."""
    try:
        run = run_seeds(_Recorded(row), simulation, row.seeds, row.split)
    except ActionError as error:
        raise RowError(f"an action of it is none: {error}") from None
    for k, each in enumerate(row.episodes):
        steps = int(np.isfinite(run.speeds[k]).sum())
        if len(each.E) != steps:
            raise RowError(f"episodes[{k}] has {len(each.E)} E and D, but must have {steps}, as many as steps")
        for name, said, taken in (("E", each.E, run.speeds[k]), ("D", each.D, run.executions[k])):
            if (other := np.flatnonzero(taken[:steps] != said)).size:
                at = other[0]
                raise RowError(
                    f"episodes[{k}].{name}[{at}] is {said[at]!r}, but such a step takes {taken[at].item()!r}"
                )
        for name in ("cost", "good", "finished"):
            if getattr(each, name) != (found := getattr(run, name)[k].item()):
                return f"episodes[{k}].{name} (seed {each.seed}) is {getattr(each, name)!r}, but comes out as {found!r}"
    for name, value in stated(run).items():
        own: Any = getattr(row, name)
        if (own is None) != (value is None) or (own and not np.allclose(own, np.array(value), rtol=NEAR, atol=0.0)):
            return f"{name} is {own}, but of its episodes it is {value}"
    return ""
