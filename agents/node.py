"""What a node does with a cell, in a folder of its own: it needs no folder in common with the machine that asks."""

import os
import pickle
import queue
import socket
import threading
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple, Protocol

from agents import likeness
from agents.parcel import Outbox, Parcel, packed, unpack
from agents.progress import Work, sentence
from grind_env.policies.problem import Problem
from grind_env.policies.tuned import tuned_folder

LOOK_SECONDS = 0.5
"""Between two looks for what a cell has written."""


class Cell(Protocol):
    """What can be worked on far away."""

    @property
    def problem(self) -> Problem:
        """What is ground."""

    @property
    def files(self) -> Sequence[str]:
        """Patterns of what is kept of it, below the folder of what is kept."""

    @property
    def trains(self) -> bool:
        """Whether an agent is trained."""


class Unlike(NamedTuple):
    """A node is not as this machine is; the sentence says in what."""

    said: str


class Ended(NamedTuple):
    """What was found, or the sentence on what failed."""

    answer: Any


@dataclass(frozen=True, slots=True)
class Order:
    """What a node needs to work on a cell.

    Attributes:
        cell: to be worked on.
        request: how.
        work: by what function.
        problem: what it must have as the machine that asks, to grind the problem.
        here: working folder of the machine that asks, in which relative names are meant.
        kept: files of the cell.
        parameters: files of the tuned parameters.
    """

    cell: Any
    request: Any
    work: Work[Any, Any, Any]
    problem: likeness.Facts
    here: str
    kept: Parcel
    parameters: Parcel


def ordered(cell: Cell, request: Any, work: Any, kept: Parcel) -> Order:
    """What a node is sent of a cell."""
    folder = _configs(cell, request)
    return Order(
        cell=cell,
        request=request,
        work=work,
        problem=likeness.of_problem(cell.problem, cell.trains),
        here=str(Path.cwd()),
        kept=kept,
        parameters=packed(folder, [f"{cell.problem.name}.toml"]),
    )


def _configs(cell: Cell, request: Any) -> Path:
    return tuned_folder(cell.problem.simulation().task, getattr(request, "configs", None))


def serve(machine: likeness.Facts, pickled: bytes) -> Iterator[Any]:
    """Work on a cell on a node: yields where, how far it is, files, and at last what has come of it.

    Args:
        machine: what the node must have as the machine that asks; with other code it might not read the order.
        pickled: an `Order`.
    """
    node = socket.gethostname()
    if said := likeness.difference(node, likeness.of_machine(), machine):
        yield Unlike(said)
        return
    order: Order = pickle.loads(pickled)
    cell, request = order.cell, order.request
    # a node that has no such folder has no files of one's own there either, and says so
    with suppress(OSError):
        os.chdir(order.here)
    yield f"on {node}"
    try:
        problem = likeness.of_problem(cell.problem, cell.trains)
    except Exception as error:
        yield Ended(sentence(error))
        return
    if said := likeness.difference(node, problem, order.problem):
        yield Unlike(said)
        return
    with TemporaryDirectory(prefix="grind-") as place:
        runs, configs = Path(place, "runs"), Path(place, "parameters")
        unpack(order.kept, runs)
        unpack(order.parameters, configs)
        outbox, told = Outbox(runs, cell.files), queue.SimpleQueue[Any]()
        there = {"runs": runs, "fresh": False, **({"configs": configs} if order.parameters else {})}
        moved = replace(request, **{each.name: there[each.name] for each in fields(request) if each.name in there})
        threading.Thread(target=_work, args=(cell, moved, order.work, told), daemon=True).start()
        ended: Ended | None = None
        while ended is None:
            done, ended = _told(told)
            if changed := outbox.changes():
                yield changed
            if done:
                yield done
        said_there = partial(_here, {configs: _configs(cell, request), runs: request.runs})
        yield Ended(said_there(ended.answer))


def _work(cell: Any, request: Any, work: Any, told: "queue.SimpleQueue[Any]") -> None:
    try:
        told.put(Ended(work(cell, request, told.put)))
    # whatever goes wrong in one cell must not stop the others
    except Exception as error:
        told.put(Ended(sentence(error)))


def _told(told: "queue.SimpleQueue[Any]") -> tuple[int, Ended | None]:
    """How much more is done, and the end if it has come, at the latest after `LOOK_SECONDS`."""
    done = 0
    with suppress(queue.Empty):
        message = told.get(timeout=LOOK_SECONDS)
        while not isinstance(message, Ended):
            done += message
            message = told.get_nowait()
        return done, message
    return done, None


def _here(folders: dict[Path, Path], answer: Any) -> Any:
    """An answer in which the folders of a node have the names that they have on the machine that asks."""
    if isinstance(answer, str):
        for there, here in folders.items():
            answer = answer.replace(str(there), str(here))
    return answer
