from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env.render.strip_chart_data import HEADROOM
from grind_env.render.terminal_view import LEVELS, SHOWN, panel
from tests.render.harness import GOOD, INSTANT, LIMITS, VIEW, with_last, with_wheel


def line(text: str, name: str) -> str:
    return next(each for each in text.splitlines() if each.startswith(name))


def test_the_panel_shows_wheel_part_readings_and_cost() -> None:
    text = panel(with_wheel(ds=297.5, A=0.0213, lam=0.12, wd=0.08))
    assert text == "\n".join(
        [
            "                  A job: block 1 of 20",
            "block             G82 X330. I-30. Y-.3 J-.02 L2 F60. E9000. P9100 D0",
            "wheel             radius 148.75 mm, 1.25 mm gone",
            "                  wear-flat area 2.13 %, loading 12 %",
            "diamond           worn 0.08 mm flat",
            "part              plate, 300 mm long, stock 0.300 mm, 3 µm left",
            "                  good part",
            "power             4.00 of 8.00 kW       ▄",
            "temperature rise  250 of 500 K          ▄",
            "Ra                0.50 of 1.00 µm       ▄",
            "table speed E     9000 mm/min           ▄",
            "dresses D         0                     ·",
            "cost              2.50 $ per good part, 0 of 1 parts scrap",
        ]
    )


def test_the_panel_has_no_readings_before_the_first_block() -> None:
    text = panel(replace(VIEW, ground=(), text=""))
    assert line(text, "block").endswith("none run yet")
    assert line(text, "power") == "power"
    assert line(text, "cost").endswith("0.00 $ and no good part, 0 of 0 parts scrap")


@pytest.mark.parametrize(
    ("change", "verdict"),
    [
        ({"rise": 501.0}, "beyond its limit: burn"),
        ({"torque": 1.01, "size_error": -10.1}, "beyond its limit: stall, size"),
        ({"roughness": 1.01}, "beyond its limit: Ra"),
        ({"good": 0.4}, "scrap"),
        ({"good": 0.0, "finished": False}, "within its limits, to be ground on"),
        ({"rise": 500.0, "power": 8000.0, "roughness": 1.0, "size_error": 10.0}, "good part"),
        ({"roughness": 5.0, "size_error": 50.0, "limits": LIMITS._replace(roughness=0.0, size=0.0)}, "good part"),
    ],
)
def test_the_verdict_names_every_exceeded_limit(change: dict[str, float], verdict: str) -> None:
    assert f" {verdict}\n" in panel(with_last(**change))


def test_while_a_block_runs_no_verdict_is_given() -> None:
    text = panel(replace(VIEW, instant=INSTANT))
    assert "good part\n" not in text
    assert "block 2 of 20" in text


@given(st.lists(st.tuples(st.floats(10.0, 30000.0), st.integers(0, 3), st.floats(0.0, 1.0)), min_size=1, max_size=90))
def test_bars_digits_and_sums_follow_the_history(history: list[tuple[float, int, float]]) -> None:
    ground = tuple(replace(GOOD, power=power, executions=count, good=good) for power, count, good in history)
    text = panel(replace(VIEW, ground=ground))
    bars = line(text, "power").split("kW")[1].strip()
    top = HEADROOM * max(LIMITS.power, max(power for power, _, _ in history))
    shown = history[-SHOWN:]
    assert bars == "".join(LEVELS[int(8 * power / top)] for power, _, _ in shown)
    count, marks = line(text, "dresses D").split()[2:]
    assert int(count) == sum(each for _, each, _ in history)
    assert marks == "".join(str(each or "·") for _, each, _ in shown)
    scrap = sum(good < 0.5 for *_, good in history)
    assert f"{scrap} of {len(history)} parts scrap" in text
    assert max(map(len, text.splitlines())) <= 100
