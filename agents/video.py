"""A policy grinding an episode, or two side by side, as an animated picture."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from agents.budgets import PICTURES
from grind_env.control.rules import dresses_due
from grind_env.envs.splits import EVERY
from grind_env.errors import GrindError
from grind_env.files import write_atomically
from grind_env.policies.held import model_beside, parted
from grind_env.policies.learned.network import LearnedPolicy
from grind_env.policies.policy import Policy, reveal
from grind_env.policies.problem import Problem
from grind_env.render.frames import TALL, render
from grind_env.render.view import EpisodePicture, ViewInstant

COLOURS = 128
"""Colours of an animation: the picture has few, and their mixtures at the edges."""
SAMPLES = 12
"""Pictures from which they are taken."""

FASTEST = 50.0
"""Pictures a second; browsers show a GIF that asks for more at a tenth of that."""

TURNS = 0.29
"""Turns of the wheel from one picture to the next, as drawn."""


TRAINED = "trained agent"
"""Title of one: who looks on does not know the names of algorithms."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Film:
    """How an animation is made.

    Raises:
        GrindError: for no picture a block, or more a second than a GIF can show.
    """

    frames: int = PICTURES
    """Pictures a block, the last of them at rest."""
    fps: float = 10.0
    hold: float = 3.0
    """s for which the last picture stays."""
    most_bytes: int = 1_500_000

    def __post_init__(self) -> None:
        if self.frames < 1 or not 1.0 <= self.fps <= FASTEST:
            raise GrindError(
                f"an animation cannot have {self.frames} pictures a block at {self.fps:g} a second:"
                f" give at least 1 a block, and 1 to {FASTEST:g} a second"
            )


def watch(policy: Policy, problem: Problem, seed: int, frames: int, split: str = EVERY) -> Iterator[EpisodePicture]:
    """The views of an episode: before the first step, then `frames` of each step, the last of them at rest.

    On a machine that is not the model, the policy holds the model.
    """
    env: Any = problem.make().unwrapped
    observation, _ = env.reset(seed=seed, options={"split": split})
    model = model_beside(problem)
    held, shown = model or env.simulation, parted(policy, env.simulation, model, env.episodes)
    policy.begin(held, 1)
    view = _titled(env.view(), policy)
    yield view
    over = False
    while not over:
        decision = policy.act(observation[None], reveal(policy.sees, held, shown(env.episodes)))
        observation, _, over, _, _ = env.step(env.codec.encode(*decision)[0])
        after = _titled(env.view(), policy)
        yield from (_in_motion(view, after, k, frames) for k in range(frames - 1))
        view = after
        yield view


def _titled(view: EpisodePicture, policy: Policy) -> EpisodePicture:
    title = TRAINED if isinstance(policy, LearnedPolicy) else policy.name.replace("_", " ")
    return replace(view, extent=replace(view.extent, title=title))


def _in_motion(before: EpisodePicture, after: EpisodePicture, k: int, frames: int) -> EpisodePicture:
    """Picture k of a step between two views: as much of its depth is gone as of its pictures."""
    block, part = after.ground[-1], after.part
    goes_on = before.ground and not before.ground[-1].finished and before.part == replace(part, left=before.part.left)
    stock = before.part.left if goes_on else part.stock
    depth = max(stock - part.left, 0.0) if goes_on else stock
    due = [dresses_due(share * depth, depth, float(block.executions)) for share in (k / frames, (k + 1) / frames)]
    number = len(before.ground) * frames + k
    instant = ViewInstant(
        table=0.8 * (-1.0) ** number,
        spin=TURNS * number,
        dressing=due[1] > due[0],
        speed=block.speed,
        executions=block.executions,
    )
    left = stock - (k + 1) / frames * depth
    return replace(before, part=replace(part, left=left), text=after.text, instant=instant)


def record(
    policies: Sequence[Policy], problem: Problem, seed: int, path: Path, film: Film | None = None, split: str = EVERY
) -> int:
    """Write an animation of the policies, if there are several side by side, on the episode of a seed.

    Args:
        policies: from left to right.
        problem: what they grind.
        seed: of the episode.
        path: a .gif file.
        film: settings.
        split: that the contexts of the episode are drawn from.

    Returns:
        Size of the file, bytes.

    Raises:
        GrindError: for another suffix or split, or if the file would be larger than `film.most_bytes`.
    """
    film = Film() if film is None else film
    if path.suffix != ".gif":
        raise GrindError(f"{path}: an animation is written as .gif; name such a file")
    films = zip(*(watch(policy, problem, seed, film.frames, split) for policy in policies), strict=True)
    pictures = _same_colours([np.hstack([render(view, TALL) for view in views]) for views in films])
    milliseconds = [round(1000.0 / film.fps)] * len(pictures)
    milliseconds[-1] = round(1000.0 * film.hold)

    def write(partial: Path) -> None:
        first, *others = pictures
        # optimised, a picture holds only the pixels that differ from the one before
        first.save(partial, save_all=True, append_images=others, duration=milliseconds, loop=0, optimize=True)
        size = partial.stat().st_size
        if size > film.most_bytes:
            most = film.most_bytes / 1e6
            raise GrindError(
                f"{path} would have {size / 1e6:.2f} MB, more than {most:.2f}: ask for fewer pictures a block"
            )

    write_atomically(path, write)
    return path.stat().st_size


def _same_colours(frames: list[NDArray[np.uint8]]) -> list[Image.Image]:
    """The pictures in one palette, so that a pixel that stays the same keeps its number.

    The palette holds the most frequent colours as they are; averages would dull the small coloured shapes.
    """
    samples = np.stack(frames[:: max(len(frames) // SAMPLES, 1)])
    codes, counts = np.unique(samples.astype(np.uint32) @ np.array([1, 1 << 8, 1 << 16]), return_counts=True)
    kept = codes[np.argsort(-counts, kind="stable")[:COLOURS]].astype("<u4")
    palette = Image.new("P", (1, 1))
    palette.putpalette(kept.view(np.uint8).reshape(-1, 4)[:, :3].tobytes())
    return [Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
