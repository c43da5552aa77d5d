from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import pytest

from agents.video import watch
from grind_env.envs.task_names import task_names
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.scripted.rules import Fixed
from grind_env.render.canvas import Box, Canvas, text_width
from grind_env.render.frames import TALL, WIDE
from grind_env.render.layout import draw_tall, draw_wide
from grind_env.render.picture_data import EpisodePicture
from tests.examples import nightly
from tests.render.harness import VIEW, with_last

DRAW = {WIDE: draw_wide, TALL: draw_tall}


def boxes(canvas: Canvas) -> Iterator[tuple[str, Box]]:
    """Yield each text and its box: 0.75 of its size above the base line, 0.2 below."""
    for (x, y), text, size, _, anchor, strong in canvas.texts:
        if text:
            width = text_width(text, size, strong)
            left = x - (width if anchor == "rs" else 0.0)
            yield text, Box(left, y - 0.75 * size, left + width, y + 0.2 * size)


def assert_legible(view: EpisodePicture, size: tuple[int, int]) -> None:
    placed = list(boxes(DRAW[size](view, *size)))
    assert len(placed) >= 10
    for text, box in placed:
        assert box.left >= 0 and box.top >= 0 and box.right <= size[0] and box.bottom <= size[1], text
    for (first, a), (second, b) in combinations(placed, 2):
        apart = a.right <= b.left or b.right <= a.left or a.bottom <= b.top or b.bottom <= a.top
        assert apart, f"{first!r} runs into {second!r}"


@pytest.mark.parametrize("size", [WIDE, nightly(TALL)])
@pytest.mark.parametrize("name", task_names())
def test_no_text_runs_into_another_or_off_the_picture(name: str, size: tuple[int, int]) -> None:
    problem = find_problem(name)
    task = problem.simulation().task
    fastest = max(task.action.speed_levels or task.action.speed_range or ())
    for k, view in enumerate(watch(Fixed(fastest, task.action.executions), problem, 1, 2)):
        if k % 7 in (0, 1) or k == 2 * task.blocks:
            assert_legible(replace(view, extent=replace(view.extent, title=task.title)), size)


@pytest.mark.parametrize("size", [WIDE, TALL])
def test_the_longest_values_fit_into_the_picture(size: tuple[int, int]) -> None:
    worst = with_last(power=98765.0, rise=1800.0, roughness=9.99, size_error=-400.0, good=0.0, cost=98765.43)
    assert_legible(replace(worst, wheel=worst.wheel._replace(ds=180.0, A=0.15, lam=1.0)), size)
    assert_legible(with_last(finished=False, good=0.0), size)


@pytest.mark.parametrize("size", [WIDE, TALL])
@pytest.mark.parametrize(
    ("title", "shown"), [("Plates", "Plates"), ("Plates " * 6, "Plates " * 6), ("Plates " * 40, "Plates Plates")]
)
def test_a_long_title_gets_smaller_then_shorter(title: str, shown: str, size: tuple[int, int]) -> None:
    view = replace(VIEW, extent=replace(VIEW.extent, title=title))
    assert_legible(view, size)
    heading = next(text for _, text, *_ in DRAW[size](view, *size).texts if text.startswith("Plates"))
    assert heading.startswith(shown)
    assert (heading == title) == (title == shown)


def test_dresses_stay_visible_in_a_job_of_many_blocks() -> None:
    many = tuple(replace(VIEW.ground[0], executions=1) for _ in range(2000))
    view = replace(VIEW, ground=many, extent=replace(VIEW.extent, blocks=2000, parts=2000))
    below = draw_wide(view, *WIDE).pixels()[455:480, 500:930].astype(int)
    # half way from white to orange at least
    assert ((below[..., 0] - below[..., 2]).max(axis=0) > 80).all()
