"""Pictures of the environments: of each task, and of eight tasks on one sheet."""

import io
from dataclasses import replace
from functools import cache
from itertools import islice

from pictures import lighter
from PIL import Image

from agents.video import watch
from grind_env.envs.task_names import CORE
from grind_env.policies.evaluation import SEEDS
from grind_env.policies.policy_lookup import named_policy, usual_name
from grind_env.policies.problem_lookup import find_problem
from grind_env.render.frames import render

ON_SHEET = (*CORE, "CBN")
COLUMNS, WIDTH, GAP = 3, 480, 8  #: columns of the sheet; width of a picture and gap between pictures, px
SHARE = 0.4  #: share of an episode that is over in the picture
UNDER = (244, 244, 240)


@cache
def still(name: str) -> Image.Image:
    """Return a picture from an episode of a task (name or id), with its bundled agent or another usual policy."""
    problem = find_problem(name)
    simulation = problem.simulation()
    policy = named_policy(usual_name(simulation), simulation)
    views = watch(policy, problem, SEEDS["evaluation"], 1)
    at = round(SHARE * simulation.task.blocks)
    *_, view = islice(views, at + 1)
    return Image.fromarray(render(replace(view, extent=replace(view.extent, title=simulation.task.title))))


def png(image: Image.Image) -> bytes:
    """Return a picture as PNG with few colours."""
    content = io.BytesIO()
    image.save(content, "PNG")
    return lighter(content.getvalue())


def sheet() -> Image.Image:
    """Return the pictures of the tasks side by side, smaller."""
    pictures = [still(name) for name in ON_SHEET]
    height = round(WIDTH * pictures[0].height / pictures[0].width)
    rows = -(-len(pictures) // COLUMNS)
    page = Image.new("RGB", (COLUMNS * (WIDTH + GAP) - GAP, rows * (height + GAP) - GAP), UNDER)
    for k, picture in enumerate(pictures):
        place = (k % COLUMNS) * (WIDTH + GAP), (k // COLUMNS) * (height + GAP)
        page.paste(picture.resize((WIDTH, height), Image.Resampling.LANCZOS), place)
    return page
