"""Where a training is kept between two updates, so that one that is killed goes on.

It holds the objects that a step changes, in a pickle, which does whatever its author wrote into it. So it lies in the
user's cache, where nobody else writes, and never beside a part program.
"""

import hashlib
import io
import pickle
import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TypeVar

import platformdirs
import torch

import grind_env
from grind_env.envs.blocks.simulation import BlockSimulation
from grind_env.envs.job.simulation import JobSimulation
from grind_env.files import FileError, write_atomically
from grind_env.kernel.cache import UNUSED
from grind_env.machine.job import Job

T = TypeVar("T")


FOUND_AGAIN = BlockSimulation, JobSimulation, Job
"""What no step changes, and a training that has been begun holds as well: it is left out."""


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A file with a training and the state of PyTorch's generator."""

    path: Path

    def read(self, begun: T) -> T:
        """The training, with whose generator PyTorch goes on; the one begun if there is none that can be read."""
        if not self.path.exists():
            return begun
        try:
            around = Saver(io.BytesIO())
            around.dump(begun)
            with self.path.open("rb") as file:
                training, generator = Loader(file, around.left_out).load()
        except Exception:  # a damaged pickle may raise anything, and all that is lost is time
            return begun
        torch.set_rng_state(generator)
        found: T = training
        return found

    def write(self, training: object) -> None:
        """Keep a training, whole or not at all: where the folder cannot be written, it begins anew if it is killed."""
        content = io.BytesIO()
        Saver(content).dump((training, torch.get_rng_state()))
        with suppress(FileError, OSError):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(self.path, lambda unfinished: unfinished.write_bytes(content.getvalue()))

    def remove(self) -> None:
        """Forget the training, which is over, and those that nobody has gone on with for long."""
        for path in self.path.parent.glob("*.checkpoint"):
            if path == self.path or time.time() - path.stat().st_mtime > UNUSED:
                path.unlink(missing_ok=True)


class Saver(pickle.Pickler):
    """Writes objects without what is found again, of which it keeps the places."""

    def __init__(self, file: IO[bytes]) -> None:
        super().__init__(file)
        self.left_out: list[object] = []

    def persistent_id(self, value: object) -> int | None:
        """The place of what is left out."""
        if not isinstance(value, FOUND_AGAIN):
            return None
        if not any(each is value for each in self.left_out):
            self.left_out.append(value)
        return next(k for k, each in enumerate(self.left_out) if each is value)


class Loader(pickle.Unpickler):
    """Reads them, with what is found again in its places."""

    def __init__(self, file: IO[bytes], left_out: Sequence[object]) -> None:
        super().__init__(file)
        self.left_out = left_out

    def persistent_load(self, place: int) -> object:
        """What belongs in a place."""
        return self.left_out[place]


def checkpoint_of(said: Iterable[object]) -> Checkpoint:
    """The checkpoint of what is said of a training; other code finds none, for it may not go on with these objects."""
    digest = hashlib.sha256(repr((torch.__version__, *said)).encode())
    for path in sorted(Path(grind_env.__file__).parent.rglob("*.py")):
        digest.update(path.read_bytes())
    folder = platformdirs.user_cache_path("grind_env") / "trainings"
    return Checkpoint(folder / f"{digest.hexdigest()[:16]}.checkpoint")
