"""The adapters of the track by name."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from agents.benchmark.trained import from_file
from agents.track.adapter import Adapter, TrackShift
from agents.track.knowing import RETUNED
from agents.track.learning import CalibratedAdapter, Trim
from grind_env.policies.guard import Guarded
from grind_env.policies.learned.saved import SUFFIX
from grind_env.policies.model_view import model_of
from grind_env.policies.naming import OWN, named_policy, own_policy
from grind_env.policies.policy import Policy
from grind_env.policies.problem import Problem
from grind_env.policies.registry import TRAINED

PLANNER = "look_ahead"
"""The planner on the belief."""
HEADLINE = (*TRAINED, PLANNER, f"{Guarded.PREFIX}{PLANNER}", CalibratedAdapter.name)
WIDE = ("adaptive_rule", RETUNED, "empirical_rule", Trim.name)
BLOCKS = (0, 60, 300, 1200)


@dataclass
class Nominal:
    """A policy that stays as it is from shift to shift; its text is one of `named_policy`."""

    text: str

    @property
    def name(self) -> str:
        return Path(self.text).name

    def start(self, problem: Problem) -> Policy:
        model = model_of(problem)
        is_file = self.text.endswith(SUFFIX)
        path, text = Path(self.text), self.text
        self.policy = from_file(path, model, self.name) if is_file else named_policy(text, model, modules=True)
        return self.policy

    def learn(self, shift: TrackShift) -> Policy:
        return self.policy


ADAPTERS: dict[str, Callable[[], Adapter]] = {
    Trim.name: Trim,
    CalibratedAdapter.name: partial(CalibratedAdapter, PLANNER),
}
"""Those that learn from shift to shift."""


def made(name: str) -> Adapter:
    """Return a new adapter: one of `ADAPTERS`, `module:name` of one's own, or any policy that stays as it is."""
    if name in ADAPTERS:
        return ADAPTERS[name]()
    own = None if name.startswith(Guarded.PREFIX) else OWN.fullmatch(name)
    found: Any = own_policy(own[1], own[2]) if own else None
    return found if hasattr(found, "start") else Nominal(name)
