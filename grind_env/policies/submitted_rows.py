"""Result rows as JSON files, and their re-run on seeds that were unknown when the row was written."""

import json
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from importlib.machinery import PathFinder
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from grind_env.array_types import Array
from grind_env.dataclass_json import FormError, formed, parsed
from grind_env.envs.distribution_splits import EVERY
from grind_env.envs.task_names import CORE, MODULE_NAMES, environment_id, task_names
from grind_env.files import read_bytes, read_text, shown, write_atomically
from grind_env.kernel.random import WORD
from grind_env.message_text import quoted
from grind_env.plants.plant_names import MODEL, modules_of
from grind_env.policies.evaluation import run_seeds
from grind_env.policies.learned.saved import SUFFIX
from grind_env.policies.mismatch_fallback import Guarded
from grind_env.policies.nominal_model import on
from grind_env.policies.policy import Policy
from grind_env.policies.policy_lookup import OWN, named_policy
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.policies.score_statistics import prediction
from grind_env.policies.scoring import Judgement
from grind_env.policies.subprocess_policy import apart
from grind_env.policies.track import BASELINE, MACHINES, TASK, run_shifts
from grind_env.task_version import TASK_VERSION, of_version

FORMAT = 2
#: names of policies of the package, which need no file of a user
OF_PACKAGE = re.compile(r"(?:guarded:)?(?:\w+|E[\d.]+D\d+)", re.ASCII)
MOST_EPISODES, MOST_SEED = 10_000, 1 << 63
#: number of random bits of a drawn seed; the bit above them is 1, so a drawn seed is larger than every frozen seed
FRESH = 62
#: largest relative error of the mean of a re-run; another processor may round the policy's numbers differently
NEAR = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class SubmittedRow:
    """Costs of a policy in the episodes of an environment.

    Raises:
        FormError: the row cannot be re-run.
    """

    id: str  #: id of the environment
    policy: str  #: name for `named_policy`; for a file, its name without the folder
    sha256: str = ""  #: hash of the policy file, hexadecimal digits; empty for a policy of the package
    plant: str = ""  #: the machine, as in `Judgement`
    model: str = ""  #: the machine that the policy computes with, as in `Judgement`
    split: str = EVERY  #: split of the contexts
    first_seed: int  #: first of the consecutive seeds
    #: cost of each episode, $; for a row of the track, cost per block on each machine with seed 0, $
    costs: tuple[float, ...]
    #: for a row of the track, cost per block of the bundled `robust` on each machine, $; else empty
    robust: tuple[float, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)  #: versions of the libraries
    task_version: int = TASK_VERSION
    format: int = FORMAT

    def __post_init__(self) -> None:
        if self.id not in map(environment_id, (*task_names(), *MODULE_NAMES)):
            raise FormError(f"id is {quoted(self.id)}, but must be that of an environment of the package")
        if not 2 <= len(self.costs) <= MOST_EPISODES or not 0 <= self.first_seed < MOST_SEED:
            raise FormError(f"it must have 2 to {MOST_EPISODES} costs, and a first seed from 0 to 2^63 - 1")
        if self.robust and (len(self.costs), len(self.robust), self.id) != (*[len(MACHINES)] * 2, environment_id(TASK)):
            raise FormError(
                f"a row of the track is of {environment_id(TASK)} and has costs of {len(MACHINES)} machines"
            )
        if modules_of(self.plant) or modules_of(self.model) or bool(self.plant) != bool(self.model):
            raise FormError(f"plant is {quoted(self.plant)}, but a row names machine and model of the package")
        if not self.sha256 and not OF_PACKAGE.fullmatch(self.policy):
            raise FormError(f"policy is {quoted(self.policy)}, but must be of the package, or have a sha256")


def policy_file(text: str) -> Path | None:
    """Return the file from which a policy is read; None for a policy of the package.

    Raises:
        FormError: the module of the policy is not a single file, or the file is a .zip.
    """
    name = text.removeprefix(Guarded.PREFIX)
    if name.endswith(".zip"):
        raise FormError(f"{quoted(name)} cannot be submitted: load the .zip in a module, and name it as module:name")
    if name.endswith(SUFFIX):
        return Path(name)
    if not (own := OWN.fullmatch(name)):
        return None
    found = PathFinder.find_spec(own[1], [str(Path.cwd()), *sys.path])
    if found is None or not (found.origin or "").endswith(".py"):
        raise FormError(f"{quoted(own[1])} is no module of one file: put the policy into one")
    return Path(str(found.origin))


def digest(path: Path) -> str:
    """Return the SHA-256 of a file in hexadecimal digits."""
    return sha256(read_bytes(path)).hexdigest()


def row_of(found: Judgement, problem: Problem, text: str) -> SubmittedRow:
    """Return the row of an evaluation; `text` names the policy, as for `named_policy`.

    Raises:
        FormError: nobody else could re-run the evaluation.
    """
    if found.sees != "measurements" or problem.arguments not in ((), (("parts", 1),)):
        raise FormError("a row is of an environment of the package and a policy that sees measurements: submit none")
    return SubmittedRow(
        id=problem.id,
        **_made_by(text),
        plant=found.plant,
        model=found.model,
        split=found.split,
        first_seed=found.first_seed,
        costs=tuple(found.evaluation.cost.tolist()),
    )


def track_row(text: str, costs: Array, robust: Array) -> SubmittedRow:
    """Return the track row of a policy from its costs per block and those of `robust`, $, both shape (machines,)."""
    of = {"costs": tuple(costs.tolist()), "robust": tuple(robust.tolist()), **_made_by(text)}
    return SubmittedRow(id=environment_id(TASK), first_seed=0, **of)


def _made_by(text: str) -> dict[str, Any]:
    """Return the fields of a row that identify the policy and the library versions."""
    path = policy_file(text)
    return {
        "policy": text if path is None else text.replace(str(path), path.name),
        "sha256": "" if path is None else digest(path),
        "versions": {name: version(name) for name in ("grind_env", "numpy", "numba")},
    }


def write_rows(path: Path, rows: Sequence[SubmittedRow]) -> None:
    """Write a row, or a list of rows, as JSON in one atomic step."""
    found = [asdict(row) for row in rows]
    text = json.dumps(found if len(found) > 1 else found[0], indent=1)
    write_atomically(path, lambda partial: partial.write_text(text, encoding="utf-8"))


def read_rows(path: Path) -> list[SubmittedRow]:
    """Return the rows in a file of at most 64 MB, without opening or running any file that the rows name.

    Raises:
        ReadError: the file cannot be read.
        FormError: the file has no rows, too many rows, or a row of another version.
    """
    try:
        found = parsed(read_text(path))
        listed = isinstance(found, list) and 1 < len(found) <= len(CORE)
        return [_row(document) for document in (found if listed else [found])]
    except FormError as error:
        raise FormError(f"{shown(path)}: {error}") from None


def _row(document: object) -> SubmittedRow:
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise FormError(f"it is no row of format {FORMAT}: name a file that `grind evaluate --submit` wrote")
    if (found := document.get("task_version")) != TASK_VERSION:
        raise FormError(f"it is {of_version(found)}: submit it anew")
    row: SubmittedRow = formed(SubmittedRow, document, "row")
    return row


def fresh_seeds(seed: int, count: int) -> list[int]:
    """Return drawn seeds: 2^62 plus the first 62 bits of the SHA-256 of `grind verify SEED K`, K from 0."""
    digests = [sha256(f"grind verify {seed} {k}".encode()).digest() for k in range(count)]
    return [(1 << FRESH) + (int.from_bytes(each[:8], "big") >> 64 - FRESH) for each in digests]


def verify(
    row: SubmittedRow, policy: str | None = None, *, seed: int | None = None, episodes: int | None = None
) -> tuple[bool, str]:
    """Return whether a row holds, and a report of its policy on the row's seeds and, with `seed`, on drawn seeds.

    Args:
        row: row from any source.
        policy: the policy file or `module:name`, if the row is not of a policy of the package; its code is run.
        seed: number for `fresh_seeds` that nobody can have guessed, for example with 20 digits; None to draw no seeds.
        episodes: number of drawn episodes; by default as many as the row has.

    Raises:
        GrindError: the policy file does not match the row, the policy fails, or split or machine does not exist.
    """
    name = row.policy
    if row.sha256:
        name = policy or ""
        if (path := policy_file(name)) is None or digest(path) != row.sha256:
            said = f"{quoted(row.policy)} with the SHA-256 {quoted(row.sha256)}"
            raise FormError(f"it is of the policy file {said}: ask for that file, and name it by --policy")
    elif policy is not None:
        raise FormError(f"it is of {quoted(row.policy)}, a policy of the package: leave out --policy")
    known = np.array([row.costs, row.robust] if row.robust else [row.costs])
    again = _costs(row, name)
    unit = "runs" if row.robust else "episodes"
    found = f"re-run of {known.shape[1]} {unit}: {_said(again)}; row: {_said(known)}"
    holds = np.allclose(again.mean(axis=1), known.mean(axis=1), rtol=NEAR, atol=0.0)
    if seed is None or not holds:
        return holds, found
    drawn = _costs(row, name, fresh_seeds(seed, episodes or known.shape[1]))
    _, low, high = prediction(_compared(known), drawn.shape[1])
    value = _compared(drawn).mean()
    ratio = f", {value:.5g} times as much" if row.robust else ""
    said = f"{drawn.shape[1]} drawn {unit}: {_said(drawn)}"
    return low <= value <= high, f"{found}\n{said}{ratio}; predicted: {low:.5g} to {high:.5g}"


def _said(costs: Array) -> str:
    """Return mean costs as text."""
    policy, *robust = costs.mean(axis=1)
    return f"{policy:.5g} $ a block and {robust[0]:.5g} $ with {BASELINE}" if robust else f"{policy:.5g} $ each"


def _compared(costs: Array) -> Array:
    """Return the costs, $; for the track, values whose mean is the ratio of the costs to the costs of `robust`."""
    if len(costs) == 1:
        return np.asarray(costs[0])
    ratio = costs[0].sum() / costs[1].sum()
    return np.asarray(ratio + (costs[0] - ratio * costs[1]) / costs[1].mean())


def _costs(row: SubmittedRow, name: str, drawn: Sequence[int] = ()) -> Array:
    """Return costs of a row's episodes or of drawn seeds, $, shape (1, N); on the track also of `robust`, (2, N)."""
    problem = on(find_problem(row.id), row.plant) if row.plant else find_problem(row.id)
    if not row.robust:
        seeds = drawn or range(row.first_seed, row.first_seed + len(row.costs))
        with apart(row.id, row.model, name) as policy:
            return run_seeds(policy, problem.simulation(), seeds, row.split).cost[None]
    sets = MACHINES[0], MACHINES[-1]
    machines = [(f"{sets[k % 2].partition(':')[0]}:{seed & WORD}", seed) for k, seed in enumerate(drawn)]
    found = []
    for plant, seed in machines or [(plant, 0) for plant in MACHINES]:
        with apart(row.id, MODEL.name, name) as policy:
            both: list[Policy] = [policy, named_policy(BASELINE, problem.simulation())]
            found.append([run_shifts(each, plant, [seed]).cost.mean() for each in both])
    return np.array(found).T
