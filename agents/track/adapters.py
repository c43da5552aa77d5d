"""The adapters of the track by name."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from agents.benchmark.trained import from_file
from agents.track.adapter import Adapter, Shift
from agents.track.knowing import RETUNED
from agents.track.learning import Calibrated, Trim
from grind_env.policies.guard import Guarded
from grind_env.policies.held import model_of, on
from grind_env.policies.learned.saved import SUFFIX
from grind_env.policies.naming import OWN, named_policy, own_policy, usual_name
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem

PLANNER = "look_ahead"
"""The planner on the belief."""
SHIPPED = "bc"
"""The agent that comes with the package for a task."""
BLOCKS = (0, 60, 300, 1200)


@dataclass
class Nominal:
    """A policy that was made on the model, or on public plants, and stays as it is from shift to shift.

    Args:
        text: as `named_policy` takes it, or `SHIPPED`.
    """

    text: str

    @property
    def name(self) -> str:
        """The text, of a file its name."""
        return Path(self.text).name

    def start(self, problem: Problem) -> Policy:
        """The policy."""
        model = model_of(problem)
        text = usual_name(model) if self.text == SHIPPED else self.text
        is_file = text.endswith(SUFFIX)
        self.policy = from_file(Path(text), model, self.name) if is_file else named_policy(text, model, modules=True)
        return self.policy

    def learn(self, shift: Shift) -> Policy:
        """The same."""
        return self.policy


@dataclass
class Recurrent:
    """The GRU of `gru_ppo`, trained over public plants, one in every episode; what it remembers is all it learns."""

    name: ClassVar[str] = "plain_gru_public"

    def start(self, problem: Problem) -> Policy:
        """The agent of seed 0; it is trained where it was not kept."""
        from agents.learning.plain import plain_agent  # torch takes seconds to load

        path = plain_agent(on(problem, "public"), self.name, "gru", 0, fresh=False)
        self.policy = from_file(path, model_of(problem), self.name)
        return self.policy

    def learn(self, shift: Shift) -> Policy:
        """The same."""
        return self.policy


HEADLINE = (SHIPPED, PLANNER, f"{Guarded.PREFIX}{PLANNER}", Recurrent.name, Calibrated.name)
WIDE = ("adaptive_rule", RETUNED, "empirical_rule", Trim.name)
ADAPTERS: dict[str, Callable[[], Adapter]] = {each.name: each for each in (Recurrent, Trim)} | {
    Calibrated.name: partial(Calibrated, PLANNER)
}
"""Those that are more than a policy."""


def made(name: str) -> Adapter:
    """A new adapter: one of `ADAPTERS`, `module:name` of one's own, or any policy that stays as it is.

    Raises:
        GrindError: there is none of that name.
    """
    if name in ADAPTERS:
        return ADAPTERS[name]()
    own = None if name.startswith(Guarded.PREFIX) else OWN.fullmatch(name)
    found: Any = own_policy(own[1], own[2]) if own else None
    return found if hasattr(found, "start") else Nominal(name)
