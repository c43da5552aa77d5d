"""Policies that choose E and D, without torch: scripted rules, planners and trained agents, and their evaluation."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from grind_env.policies.mismatch_fallback import guarded

__all__ = ["guarded"]


def __getattr__(name: str) -> Any:
    """Import slow modules on first use."""
    if name in __all__:
        return getattr(import_module("grind_env.policies.mismatch_fallback"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
