"""Reference scores of the registered environments: costs of known policies, and the scale of scores.

Score 0 is the best plan that can be written into a program without sensors. Score 100 is a planner that knows the
whole episode beforehand. `python -m agents scores` measures the numbers in `envs/scores.toml`.
"""

import functools
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple

from grind_env.errors import GrindError
from grind_env.files import ReadError
from grind_env.message_text import quoted, reason
from grind_env.task_version import TASK_VERSION
from grind_env.toml import TomlError, read_toml, toml_text

FILE = Path(__file__).with_name("envs") / "scores.toml"


EPISODES = 256  #: evaluation episodes of the reference scores
HEADING = "# Reference scores"
VERSION = "task_version"  #: key of the task version of the scores


class ScoreError(GrindError):
    """Environment without reference scores, or damaged file of reference scores."""


class Mean(NamedTuple):
    """Mean episode return and its standard error. `value` and `error` have no unit."""

    value: float
    error: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """Reference scores of one environment. Returns are mean episode returns, costs $ an episode."""

    zero: float  #: return, with no unit, that scores 0: the best fixed plan
    hundred: float  #: return, with no unit, that scores 100: the hindsight planner
    ratio: bool  #: whether both costs are so close that `normalise` returns the cost relative to the fixed plan's
    fixed_plan: str  #: policy of `zero`
    best_scripted: str  #: best scripted policy on measurements
    J_fix: float  #: cost of the best fixed plan on all its episodes, $
    J_plan: float  #: cost of the planner, $
    returns: Mapping[str, Mean]  #: mean episode return, with no unit, by policy


def normalise(environment_id: str, episode_return: float) -> float:
    """Return the score of a mean episode return in an environment with its default arguments.

    Returns:
        0 for the best fixed plan, 100 for the hindsight planner, linear between and beyond. In `grind/Slot-v0` both
        cost nearly the same; there the score is the ratio of the cost to the cost of the best constant.

    Raises:
        ScoreError: if the environment has no reference scores.
    """
    scale = reference(environment_id)
    if scale.ratio:
        return episode_return / scale.zero
    return 100.0 * (episode_return - scale.zero) / (scale.hundred - scale.zero)


def reference(environment_id: str) -> Reference:
    """Return the reference scores of an environment.

    Raises:
        ScoreError: if it has none.
    """
    known = _references()
    if environment_id not in known:
        measured = f"choose from {', '.join(known)}" if known else f"none are of task version {TASK_VERSION} yet"
        raise ScoreError(f"{quoted(environment_id)} has no reference scores: {measured}")
    return known[environment_id]


def find_reference(environment_id: str) -> Reference | None:
    """Return the reference scores of an environment; None if it has none."""
    return _references().get(environment_id)


@functools.cache
def _references() -> dict[str, Reference]:
    return read_references(FILE)


def read_references(path: Path) -> dict[str, Reference]:
    """Return the reference scores of this task version in a file, by environment id; empty without a file.

    Raises:
        ScoreError: the file has another form than `write_text` writes.
    """
    if not path.exists():
        return {}
    try:
        document = read_toml(path)
        known = {name: _reference(table) for name, table in document.items()}
        return {name: each for name, each in known.items() if document[name].get(VERSION) == TASK_VERSION}
    except (ReadError, TomlError, TypeError, KeyError, AttributeError) as error:
        raise ScoreError(f"{path} is damaged ({reason(error)}): delete it and run `python -m agents scores`") from error


def _reference(table: Mapping[str, Any]) -> Reference:
    plain = {key: value for key, value in table.items() if key != VERSION}
    returns = {policy: Mean(*pair) for policy, pair in table["returns"].items()}
    return Reference(**{**plain, "returns": returns})


def write_text(references: Mapping[str, Reference]) -> str:
    """Return the text of a file of reference scores."""
    tables = {name: {VERSION: TASK_VERSION, **asdict(each)} for name, each in sorted(references.items())}
    heading = f"{HEADING}, written by `python -m agents scores`; see grind_env/score_scale.py."
    return f"{heading}\n# Returns are of one episode: mean and standard error.\n\n{toml_text(tables)}\n"
