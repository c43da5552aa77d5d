import subprocess
import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from grind_env.render import palette
from grind_env.render.frames import TALL, WIDE, render
from grind_env.render.picture_data import EpisodePicture, RenderError
from tests.examples import few
from tests.render.harness import CHARTS, GOOD, INSTANT, LIMITS, MACHINE, TRAY, VIEW, near, runs, with_last, with_wheel

BLOCK_STRIP = 493  #: first row of the wide picture that belongs to the block text


def wheel_height(view: EpisodePicture) -> int:
    """Return the height in pixels of the wheel's colour in the column through its middle."""
    machine = render(view)[MACHINE]
    rows = np.flatnonzero(near(machine, palette.wear_colour(view.wheel.A))[:, 229])
    return int(rows.max() - rows.min())


def wheel_bottom(view: EpisodePicture) -> int:
    machine = render(view)[MACHINE]
    return int(np.flatnonzero(near(machine, palette.wear_colour(view.wheel.A))[:, 229]).max())


def scorched(view: EpisodePicture) -> int:
    """Count the pixels of the part that are browner than steel."""
    machine = render(view)[MACHINE][185:230].astype(int)
    return int(np.count_nonzero(machine[..., 0] > machine[..., 2] + 40))


@pytest.mark.parametrize("size", [WIDE, TALL])
def test_a_picture_is_an_array_of_bytes_and_the_same_every_time(size: tuple[int, int]) -> None:
    picture = render(VIEW, size)
    assert (picture.shape, picture.dtype) == ((size[1], size[0], 3), np.uint8)
    assert picture.flags.c_contiguous
    assert np.array_equal(picture, render(VIEW, size))
    again = render(VIEW, size)
    again[:] = 0
    assert np.array_equal(picture, render(VIEW, size))


def test_a_smaller_wheel_is_drawn_smaller() -> None:
    heights = [wheel_height(with_wheel(ds=ds)) for ds in (300.0, 299.0, 297.0, 290.0, 270.0, 200.0)]
    assert all(larger > smaller for larger, smaller in pairwise(heights))
    assert heights[-1] > 0.5 * heights[0]


def test_the_wheel_goes_from_blue_to_red_as_it_dulls() -> None:
    redness = []
    for area in (0.005, 0.015, 0.025, 0.05, 0.12):
        pixel = render(with_wheel(A=area))[MACHINE][wheel_bottom(with_wheel(A=area)) - 4, 229].astype(int)
        redness.append(pixel[0] - pixel[2])
    assert redness[0] < -60
    assert redness[-1] > 60
    assert redness == sorted(redness)


def test_the_wheel_stands_higher_if_more_stock_is_left() -> None:
    bottoms = {
        left: wheel_bottom(replace(VIEW, instant=INSTANT, part=replace(VIEW.part, left=left)))
        for left in (0.0, 0.15, 0.3)
    }
    assert bottoms[0.0] - bottoms[0.15] == pytest.approx(bottoms[0.15] - bottoms[0.3], abs=1)
    assert bottoms[0.0] - bottoms[0.3] >= 15


def test_a_burn_leaves_a_mark_and_a_hotter_burn_a_bluer_mark() -> None:
    limit = LIMITS.rise
    assert scorched(with_last(rise=limit)) == 0
    assert scorched(with_last(rise=1.02 * limit)) > 100
    hot = render(with_last(rise=1.6 * limit))[MACHINE]
    assert np.count_nonzero(near(hot, palette.TEMPER[-1])) > 20
    assert not near(render(with_last(rise=1.02 * limit))[MACHINE], palette.TEMPER[-1]).any()


def test_a_burn_mark_disappears_with_its_part() -> None:
    burnt = with_last(rise=1.3 * LIMITS.rise)
    assert scorched(burnt) > 100
    assert scorched(replace(burnt, instant=INSTANT, part=replace(burnt.part, left=0.3))) == 0
    assert scorched(replace(burnt, ground=(*burnt.ground, GOOD))) == 0


def test_the_table_moves_and_the_diamond_comes_below_the_wheel() -> None:
    def diamond(view: EpisodePicture) -> float:
        return float(np.flatnonzero(near(render(view)[MACHINE], palette.DIAMOND).any(axis=0)).mean())

    left, right = (diamond(replace(VIEW, instant=replace(INSTANT, table=table))) for table in (-1.0, 1.0))
    assert left < diamond(VIEW) < right
    assert diamond(VIEW) - left == pytest.approx(right - diamond(VIEW), abs=1.0)
    assert diamond(replace(VIEW, instant=replace(INSTANT, dressing=True))) == pytest.approx(229.0, abs=1.0)


def test_values_beyond_their_limits_are_marked_in_the_charts() -> None:
    def marks(view: EpisodePicture) -> int:
        # the texts on the right are red too
        return int(np.count_nonzero(near(render(view)[CHARTS][:, :300], palette.BRICK)))

    assert marks(VIEW) == 0
    power = marks(with_last(power=LIMITS.power + 1.0))
    assert power > 10
    assert marks(with_last(power=LIMITS.power + 1.0, rise=501.0, roughness=1.1)) == pytest.approx(3 * power, rel=0.2)


def test_the_bar_of_a_dress_is_as_high_as_its_number_of_executions() -> None:
    executions = (0, 1, 0, 3, 2, 0, 0, 1)
    ground = tuple(replace(GOOD, executions=count) for count in executions)
    # leave out the text on the right, which has the colour of the bars
    bars = near(render(replace(VIEW, ground=ground))[CHARTS][:, :300], palette.ORANGE)
    columns = bars.sum(axis=0)
    assert runs(columns > 0) == 4
    starts = np.flatnonzero((columns > 0) & (np.roll(columns, 1) == 0))
    heights = [columns[start : start + 8].max() for start in starts]
    assert np.array(heights) / heights[0] == pytest.approx([1.0, 3.0, 2.0, 1.0], rel=0.15)


def test_the_tray_shows_good_scrap_and_coming_parts() -> None:
    ground = tuple(replace(GOOD, good=good) for good in (1.0, 0.9, 0.2, 1.0, 0.0, 0.49))
    tray = render(replace(VIEW, ground=ground))[TRAY]
    foot = tray[near(tray, palette.EDGE).any(axis=1).argmax() + 1]
    assert runs(near(foot[None], palette.TEAL)[0]) == 3
    assert runs(near(tray, palette.BRICK).any(axis=0)) == 3
    assert runs(near(foot[None], palette.EDGE)[0]) == 14


def test_the_block_text_changes_only_its_own_strip_of_the_picture() -> None:
    first, second = render(VIEW), render(replace(VIEW, text=VIEW.text.replace("E9000.", "E8000.")))
    changed = np.flatnonzero((first != second).any(axis=(1, 2)))
    assert changed.min() >= BLOCK_STRIP


def test_another_size_is_refused() -> None:
    with pytest.raises(RenderError, match=r"\(640, 480\), but must be \(960, 540\) or \(480, 640\)"):
        render(VIEW, (640, 480))


NO_DRAWING = """
import importlib.abc, sys

class Missing(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in MISSING:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Missing())
DRAWING = ("PIL", "tkinter", "pygame", "matplotlib")
import gymnasium as gym
import grind_env
from grind_env.errors import GrindError
from grind_env.envs import picture_builder as episode
from grind_env.render import frames, terminal_view
env = gym.make("grind/Oracle6-v0")
env.reset(seed=0)
simulation, episodes = env.unwrapped.simulation, env.unwrapped.episodes
view = env.unwrapped.simulation.viewer.view(episodes, 0, [], [])
terminal_view.panel(view)
print([name for name in DRAWING if name in sys.modules])
try:
    frames.render(view)
    print([name for name in DRAWING if name in sys.modules])
    frames.open_window("grind")
except GrindError as error:
    print(error)
"""


def lines(*missing: str) -> list[str]:
    script = NO_DRAWING.replace("MISSING", repr(missing))
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, env={"HOME": "/"}
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_pillow_loads_with_the_first_picture_and_a_missing_screen_names_the_remedy() -> None:
    before, after, message = lines()
    assert (before, after) == ("[]", "['PIL']")
    assert message.startswith("there is no screen (")
    assert message.endswith('): use render_mode="rgb_array" or "ansi"')


@pytest.mark.parametrize(
    ("library", "said"),
    few(
        [
            ("PIL", "pictures need Pillow: pip install '.[render]' in the checkout of grind_env"),
            ("tkinter", 'this Python has no tkinter: install it (python3-tk), or use render_mode="rgb_array"'),
        ]
    ),
)
def test_a_missing_library_names_the_remedy(library: str, said: str) -> None:
    assert lines(library)[-1] == said
