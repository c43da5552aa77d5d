"""Stills of the environments: `python docs/tools/gallery.py FILE.png` puts those of the tasks on one sheet."""

import io
import sys
from dataclasses import replace
from functools import cache
from itertools import islice
from pathlib import Path

from pictures import lighter
from PIL import Image

from agents.video import watch
from grind_env.envs.task_names import CORE
from grind_env.policies.evaluation import SEEDS
from grind_env.policies.policy_lookup import named_policy, usual_name
from grind_env.policies.problem import find_problem
from grind_env.render.frames import render

ON_SHEET = (*CORE, "CBN")
COLUMNS, WIDTH, GAP = 3, 480, 8
"""Of the sheet; px."""
SHARE = 0.4
"""Of an episode, that is over."""
UNDER = (244, 244, 240)


@cache
def still(name: str) -> Image.Image:
    """A task, by name or id, in the middle of an episode of its shipped agent, or of what stands in for one."""
    problem = find_problem(name)
    simulation = problem.simulation()
    policy = named_policy(usual_name(simulation), simulation)
    views = watch(policy, problem, SEEDS["evaluation"], 1)
    at = round(SHARE * simulation.task.blocks)
    *_, view = islice(views, at + 1)
    return Image.fromarray(render(replace(view, extent=replace(view.extent, title=simulation.task.title))))


def png(image: Image.Image) -> bytes:
    """The picture in few colours."""
    content = io.BytesIO()
    image.save(content, "PNG")
    return lighter(content.getvalue())


def sheet() -> Image.Image:
    """Stills side by side, smaller."""
    pictures = [still(name) for name in ON_SHEET]
    height = round(WIDTH * pictures[0].height / pictures[0].width)
    rows = -(-len(pictures) // COLUMNS)
    page = Image.new("RGB", (COLUMNS * (WIDTH + GAP) - GAP, rows * (height + GAP) - GAP), UNDER)
    for k, picture in enumerate(pictures):
        place = (k % COLUMNS) * (WIDTH + GAP), (k // COLUMNS) * (height + GAP)
        page.paste(picture.resize((WIDTH, height), Image.Resampling.LANCZOS), place)
    return page


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(png(sheet()))
