"""The state file of an adviser, complete at any interruption, and the log beside it.

The file holds readings and advice, block by block. A resumed session gives all readings to a new adviser, because
policy and belief depend only on the readings.
"""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from grind_env.dataclass_json import formed
from grind_env.envs.input_comparison import describe_differences, differing, inputs_of, named
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.program_episode import Words
from grind_env.errors import GrindError
from grind_env.file_lock import alone
from grind_env.files import FileError, is_file, read_bytes, read_text, shown, write_atomically, write_csv
from grind_env.machine.part.feed_moves import speed_word
from grind_env.message_text import reason
from grind_env.policies.policy import Policy
from grind_env.shop.advise.file_kinds import LOG_COLUMNS
from grind_env.shop.advise.operator_readings import NAMES, MachineReadings

FORMAT = 2
ANEW = "give --restart to begin anew, or --state for another file"


class StateError(GrindError):
    """State file that is damaged, or of another batch."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AdviceOrigin:
    """Inputs behind the advice of a file."""

    inputs: Mapping[str, float | bool | str]  #: inputs of the simulation, and the wear of the wheel at the start
    policy: str  #: name of the policy, and a hash of it


@dataclass(frozen=True, slots=True, kw_only=True)
class AdvisedBlock:
    """Ground block with its advice and readings."""

    time: str  #: time of the readings, ISO 8601
    words: Words  #: advised words, by letter
    readings: MachineReadings  #: readings of the block


def origin_of(simulation: JobSimulation, policy: Policy, file: Path | None, how: str = "") -> AdviceOrigin:
    """Return the inputs behind the advice."""
    rule = (read_bytes(file) if file is not None else repr(policy).encode()) + how.encode()
    return AdviceOrigin(
        inputs={**inputs_of(simulation), **dict(named(simulation.job.wheel, "wheel"))},
        policy=f"{policy.name} {hashlib.sha256(rule).hexdigest()[:16]}",
    )


def read_state(path: Path, origin: AdviceOrigin) -> Sequence[AdvisedBlock]:
    """Return the saved blocks of a state file; none if there is no file."""
    if not is_file(path):
        return ()
    try:
        document = json.loads(read_text(path))
        if document["format"] != FORMAT:
            raise StateError(f"{shown(path)} was written by another version of grind_env: {ANEW}")
        found: AdviceOrigin = formed(AdviceOrigin, document["origin"], "origin")
        steps: tuple[AdvisedBlock, ...] = formed(tuple[AdvisedBlock, ...], document["steps"], "steps")
    except StateError:
        raise
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise StateError(f"{shown(path)} is no state of an adviser, or damaged ({reason(error)}): {ANEW}") from None
    if names := differing(origin.inputs, found.inputs):
        differences = describe_differences(names, origin.inputs, found.inputs)
        raise StateError(f"{shown(path)} was written for another part: {differences}; {ANEW}")
    if found.policy != origin.policy:
        raise StateError(f"{shown(path)} was written with another policy: {ANEW}")
    return steps


@contextmanager
def locked_state(path: Path) -> Iterator[None]:
    """Lock a state file, so that one adviser at a time works with it, and release it at the end."""
    place = Path(os.path.realpath(path))
    taken = StateError(
        f"another adviser works with {shown(path)}: go on there, or end it first, or name another file with --state"
    )
    with ExitStack() as stack:
        try:
            stack.enter_context(alone(place.with_name(f".grind-{place.name}.lock"), taken))
        except OSError as error:
            raise FileError(f"{shown(path)} cannot be kept: {error.strerror or error}; name another file") from None
        yield


def write_state(path: Path, origin: AdviceOrigin, steps: Sequence[AdvisedBlock]) -> None:
    """Write the state file atomically; errors as in `write_atomically`."""
    document = {
        "format": FORMAT,
        "origin": asdict(origin),
        "steps": [{"time": step.time, "words": step.words, "readings": step.readings.given()} for step in steps],
    }
    text = json.dumps(document, indent=1)
    write_atomically(path, lambda partial: partial.write_text(text, encoding="utf-8"))


def write_log(path: Path, simulation: JobSimulation, steps: Sequence[AdvisedBlock]) -> None:
    """Write a CSV file with a row for each ground block, atomically; errors as in `write_atomically`."""
    names = [name for name in NAMES if name not in ("block", "part", "E", "D")]
    rows = [[*LOG_COLUMNS, *names]]
    for number, step in enumerate(steps):
        given: dict[str, Any] = {
            name: int(value) if isinstance(value, bool) else value for name, value in step.readings.given().items()
        }
        advised = [step.words[speed_word(simulation.blocks[number].plan)], step.words.get("D", "")]
        ground = [given.get("E", advised[0]), given.get("D", advised[1])]
        row = [step.time, number + 1, simulation.blocks[number].part + 1, *advised, *ground]
        rows.append([*row, *(given.get(name, "") for name in names)])
    write_csv(path, rows)
