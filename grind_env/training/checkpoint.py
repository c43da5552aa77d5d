"""Checkpoints of `grind train`: a killed training resumes from its last update.

A checkpoint is a pickle of the objects that training changes. Loading a pickle runs code that its author chose.
Therefore checkpoints lie in the user's cache, which only the user writes, and never beside a part program.
"""

import hashlib
import io
import pickle
import time
import warnings
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TypeVar

import platformdirs
import torch

import grind_env
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.errors import GrindWarning
from grind_env.files import FileError, write_atomically
from grind_env.kernel.cache import UNUSED
from grind_env.machine.job import Job

T = TypeVar("T")

#: types that training does not change. A new training holds equal objects, which take the place of those saved
UNCHANGED = BlockSimulation, JobSimulation, Job


@dataclass(frozen=True, slots=True)
class Checkpoint:
    """A file with a training and the state of PyTorch's random generator."""

    path: Path

    def resume(self, begun: T) -> T:
        """Return the training in the file and set PyTorch's generator; without a file, return the one just begun.

        A damaged file gives a `GrindWarning`, and the training begins anew.
        """
        if not self.path.exists():
            return begun
        try:
            around = Saver(io.BytesIO())
            around.dump(begun)
            with self.path.open("rb") as file:
                training, generator = Loader(file, around.left_out).load()
            torch.set_rng_state(generator)
        except Exception:  # a damaged pickle may raise anything
            warnings.warn(f"{self.path} is damaged: the training begins anew", GrindWarning, stacklevel=2)
            return begun
        found: T = training
        return found

    def write(self, training: object) -> None:
        """Replace the file atomically. If the folder cannot be written, the training goes on without a checkpoint."""
        content = io.BytesIO()
        Saver(content).dump((training, torch.get_rng_state()))
        with suppress(FileError, OSError):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(self.path, lambda unfinished: unfinished.write_bytes(content.getvalue()))

    def remove(self) -> None:
        """Delete the file of a finished training, and checkpoints that nobody has resumed for 30 days."""
        for path in self.path.parent.glob("*.checkpoint"):
            with suppress(OSError):  # another training may have deleted it
                if path == self.path or time.time() - path.stat().st_mtime > UNUSED:
                    path.unlink()


class Saver(pickle.Pickler):
    """A pickler that leaves out objects of the types `UNCHANGED` and numbers them."""

    def __init__(self, file: IO[bytes]) -> None:
        super().__init__(file)
        self.left_out: list[object] = []

    def persistent_id(self, value: object) -> int | None:
        if not isinstance(value, UNCHANGED):
            return None
        if not any(each is value for each in self.left_out):
            self.left_out.append(value)
        return next(k for k, each in enumerate(self.left_out) if each is value)


class Loader(pickle.Unpickler):
    """An unpickler that inserts other objects for those that `Saver` has left out."""

    def __init__(self, file: IO[bytes], left_out: Sequence[object]) -> None:
        super().__init__(file)
        self.left_out = left_out

    def persistent_load(self, place: int) -> object:
        return self.left_out[place]


def find_checkpoint(inputs: Iterable[object]) -> Checkpoint:
    """Return the checkpoint of a training with these inputs and this code; different inputs need different `repr`."""
    digest = hashlib.sha256(repr((torch.__version__, *inputs)).encode())
    for path in sorted(Path(grind_env.__file__).parent.rglob("*.py")):
        digest.update(path.read_bytes())
    folder = platformdirs.user_cache_path("grind_env") / "trainings"
    return Checkpoint(folder / f"{digest.hexdigest()[:16]}.checkpoint")
