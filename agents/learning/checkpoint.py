"""Checkpoints of a training, so that it survives being killed at any moment.

A checkpoint holds the agent whole: networks and optimiser, buffers, the environments with their generators and the
memory of the features, and the state of the global generators. It is a pickle, for the program that wrote it and
never for a stranger; policies that are handed on are saved otherwise (`grind_env.policies.learned.saved`).
"""

import hashlib
import pickle
import random
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.logger import Logger

import agents.learning
import grind_env
from agents.learning.curve import Point
from grind_env.errors import GrindError, reason


class CheckpointError(GrindError):
    """A checkpoint that cannot be read or written."""


@dataclass(slots=True)
class Training:
    """A training between two updates."""

    model: BaseAlgorithm
    points: list[Point]
    """Of the curve so far."""
    seconds: dict[str, float]
    """Wall time by what it was spent on."""


def checkpoint_path(stem: Path) -> Path:
    """Where the checkpoint of a training lies: its name, and a hash of the code whose objects it holds.

    Other code may not be able to go on with these objects, even where it would end in the same agent.
    """
    digest = hashlib.sha256()
    for package in (grind_env, agents.learning):
        for path in sorted(Path(str(package.__file__)).parent.rglob("*.py")):
            digest.update(path.read_bytes())
    return stem.with_name(f"{stem.name}-{digest.hexdigest()[:8]}.checkpoint")


def remove_checkpoints(stem: Path) -> None:
    """Remove the checkpoints of a training, those of other code and unfinished ones too."""
    for pattern in (f"{stem.name}-*.checkpoint", f".{stem.name}-*.checkpoint.partial"):
        for path in stem.parent.glob(pattern):
            path.unlink(missing_ok=True)


def write_checkpoint(path: Path, training: Training) -> None:
    """Write a checkpoint, whole or not at all; nothing of the training changes by it.

    Raises:
        CheckpointError: if the file cannot be written.
    """
    generators = random.getstate(), np.random.get_state(), torch.get_rng_state()
    logger = training.model.logger
    # its open files cannot be kept
    training.model.set_logger(Logger(None, []))
    # of the same name each time: what a killed program leaves is overwritten
    partial = path.with_name(f".{path.name}.partial")
    try:
        torch.save((training, generators), partial)
    except (OSError, RuntimeError) as error:
        # PyTorch says so of a file that it cannot open, and of a full disk
        raise CheckpointError(
            f"{path} cannot be written ({reason(error)}): name another folder or make room"
        ) from error
    finally:
        training.model.set_logger(logger)
    partial.replace(path)


def read_checkpoint(path: Path) -> Training:
    """The training in a checkpoint; the global generators go on from where they were.

    Raises:
        CheckpointError: if the file is damaged.
    """
    try:
        training, generators = torch.load(path, weights_only=False)
    except (OSError, EOFError, pickle.UnpicklingError, zipfile.BadZipFile, RuntimeError, ValueError) as error:
        raise CheckpointError(f"{path} is damaged: delete it, or train with --fresh") from error
    state: tuple[Any, Any, torch.Tensor] = generators
    random.setstate(state[0])
    np.random.set_state(state[1])
    torch.set_rng_state(state[2])
    found: Training = training
    return found
