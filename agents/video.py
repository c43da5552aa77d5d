"""Animations of one or two policies that grind an episode."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from agents.command_defaults import PICTURES
from grind_env.control.cycle_formulas import dresses_due
from grind_env.envs.distribution_splits import EVERY
from grind_env.errors import GrindError
from grind_env.files import write_atomically
from grind_env.policies.learned.network import LearnedPolicy
from grind_env.policies.played_episodes import stepped
from grind_env.policies.policy import Policy
from grind_env.policies.problem_lookup import Problem
from grind_env.render.frames import TALL, render
from grind_env.render.picture_data import EpisodePicture, PictureInstant

COLOURS = 128  #: number of colours of an animation: a picture has few colours, and mixtures of them at its edges
SAMPLES = 12  #: number of pictures from which the colours are taken

PICTURE, LAST = 100, 3000  #: time for which a picture stays, and time of the last picture, ms
MOST_BYTES = 1_500_000

TURNS = 0.29  #: turns of the wheel from one picture to the next, as drawn


TRAINED = "trained agent"  #: title of all trained agents, because viewers do not know the names of algorithms


def watch(policy: Policy, problem: Problem, seed: int, frames: int, split: str = EVERY) -> Iterator[EpisodePicture]:
    """Return the views of an episode: before the first step, then `frames` of each step, the last of them at rest.

    On an out-of-model machine, the policy computes with the model.
    """
    title = TRAINED if isinstance(policy, LearnedPolicy) else policy.name.replace("_", " ")
    view: EpisodePicture | None = None
    for env, _ in stepped(policy, problem, seed, split):
        before, shown = view, env.view()
        view = replace(shown, extent=replace(shown.extent, title=title))
        if before is not None:
            yield from (_in_motion(before, view, k, frames) for k in range(frames - 1))
        yield view


def _in_motion(before: EpisodePicture, after: EpisodePicture, k: int, frames: int) -> EpisodePicture:
    """Return picture k of a step between two views; the depth is ground in proportion to the number of pictures."""
    block, part = after.ground[-1], after.part
    goes_on = before.ground and not before.ground[-1].finished and before.part == replace(part, left=before.part.left)
    stock = before.part.left if goes_on else part.stock
    depth = max(stock - part.left, 0.0) if goes_on else stock
    due = [dresses_due(share * depth, depth, float(block.executions)) for share in (k / frames, (k + 1) / frames)]
    number = len(before.ground) * frames + k
    instant = PictureInstant(
        table=0.8 * (-1.0) ** number,
        spin=TURNS * number,
        dressing=due[1] > due[0],
        speed=block.speed,
        executions=block.executions,
    )
    left = stock - (k + 1) / frames * depth
    return replace(before, part=replace(part, left=left), text=after.text, instant=instant)


def record(
    policies: Sequence[Policy], problem: Problem, seed: int, path: Path, frames: int = PICTURES, split: str = EVERY
) -> int:
    """Write an animation of the policies, side by side, on the episode of a seed; return the size of the file, bytes.

    Raises:
        GrindError: the file is no .gif, or would be larger than `MOST_BYTES`.
    """
    if path.suffix != ".gif":
        raise GrindError(f"{path}: an animation is written as .gif; name such a file")
    films = zip(*(watch(policy, problem, seed, frames, split) for policy in policies), strict=True)
    pictures = _same_colours([np.hstack([render(view, TALL) for view in views]) for views in films])
    milliseconds = [PICTURE] * (len(pictures) - 1) + [LAST]

    def write(partial: Path) -> None:
        first, *others = pictures
        # optimised, a picture holds only the pixels that differ from the one before
        first.save(partial, save_all=True, append_images=others, duration=milliseconds, loop=0, optimize=True)
        size = partial.stat().st_size
        if size > MOST_BYTES:
            raise GrindError(
                f"{path} would have {size / 1e6:.2f} MB, more than {MOST_BYTES / 1e6:g}: ask for fewer pictures a block"
            )

    write_atomically(path, write)
    return path.stat().st_size


def _same_colours(frames: list[NDArray[np.uint8]]) -> list[Image.Image]:
    """Return the pictures in one palette, so that a pixel that stays the same keeps its number.

    The palette holds the most frequent colours as they are; averages would dull the small coloured shapes.
    """
    samples = np.stack(frames[:: max(len(frames) // SAMPLES, 1)])
    codes, counts = np.unique(samples.astype(np.uint32) @ np.array([1, 1 << 8, 1 << 16]), return_counts=True)
    kept = codes[np.argsort(-counts, kind="stable")[:COLOURS]].astype("<u4")
    palette = Image.new("P", (1, 1))
    palette.putpalette(kept.view(np.uint8).reshape(-1, 4)[:, :3].tobytes())
    return [Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
