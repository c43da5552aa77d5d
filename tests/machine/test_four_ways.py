"""Equal strokes written in four ways: as cycles, as a G81 each, as feed moves, and as loops of feed moves."""

from typing import NamedTuple

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from grind_env.machine.record import GrindingRecord
from tests.examples import examples
from tests.machine.harness import run
from tests.machine.test_feed_strokes import AWAY, HEAD, assert_same_strokes, job


class Pass(NamedTuple):
    """Strokes of a G82: one, then one for each pick, then L more."""

    pick: int  #: depth per pick, um
    picks: int
    L: int
    E: int

    def depths(self, begun: int) -> list[int]:
        """Return the depths of its strokes, um, from a depth on."""
        to = [begun + self.pick * number for number in range(self.picks + 1)]
        return to + to[-1:] * self.L


def start(begun: int) -> str:
    return f"G90 G00 Y20.\nX-30.\nG01 Y-{0.001 * begun:.3f} F500.\n"


def by_cycle(each: Pass, begun: int) -> str:
    """Return a G82 with picks down to its depth."""
    depth = 0.001 * each.depths(begun)[-1]
    return f"G82 X230. I-30. Y-{depth:.3f} J-{0.001 * each.pick:.3f} L{each.L} F500. E{each.E}.\nG80\n"


def by_tables(each: Pass, begun: int) -> str:
    """Return a G81 for each stroke, stopped after it, from alternating sides."""
    lines = []
    for number, depth in enumerate(each.depths(begun)):
        ends = ("X230. I-30.", "X-30. I230.")[number % 2]
        lines.append(f"G01 Y-{0.001 * depth:.3f} F500.\nG81 {ends} E{each.E}.\nG04 P.01\nG80\n")
    return "".join(lines)


def by_moves(each: Pass, begun: int) -> str:
    """Return a feed move for each stroke."""
    lines = []
    for number, depth in enumerate(each.depths(begun)):
        lines.append(f"G01 Y-{0.001 * depth:.3f} F500.\nX{(230, -30)[number % 2]}. F{each.E}.\n")
    return "".join(lines)


def by_loop(each: Pass, begun: int) -> str:
    """Return a loop that computes depth and end of each stroke."""
    return (
        f"#1=0\n#2=230\nWHILE [#1 LE {each.picks + each.L}] DO 1\n#3=#1\n"
        f"IF [#3 GT {each.picks}] THEN #3={each.picks}\n"
        f"G01 Y[0-[{begun}+{each.pick}*#3]/1000] F500.\nX#2 F{each.E}.\n#2=200-#2\n#1=#1+1\nEND 1\n"
    )


WAYS = (by_cycle, by_tables, by_moves, by_loop)


def in_each_way(passes: list[Pass], width: float) -> list[GrindingRecord]:
    shop, texts = job(width=width), [""] * len(WAYS)
    begun = 0
    for each in passes:
        texts = [text + start(begun) + way(each, begun) for text, way in zip(texts, WAYS, strict=True)]
        begun = each.depths(begun)[-1]
    return [run(f"{HEAD}{text}{AWAY}M30\n", shop) for text in texts]


feeds = st.integers(30, 300).map(lambda hundreds: 100 * hundreds)
some = st.builds(Pass, st.integers(1, 20), st.integers(1, 5), st.integers(0, 3), feeds)


@given(st.lists(some, min_size=1, max_size=3), st.sampled_from([20.0, 24.7, 40.0]))
@examples(40)
def test_strokes_wheel_and_part_are_equal_in_all_four_ways(passes: list[Pass], width: float) -> None:
    # after an odd number of strokes the table makes one more before the next cycle: the number is even here
    passes = [each._replace(L=each.L + (each.picks + each.L + 1) % 2) for each in passes]
    cycle, tables, moves, loop = in_each_way(passes, width)
    assert len(moves.strokes) == sum(1 + each.picks + each.L for each in passes)
    assert_same_strokes(moves, tables)
    assert_same_strokes(moves, loop)
    for name in ("time", "seconds"):
        np.testing.assert_allclose(tables.strokes[name], moves.strokes[name], rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(loop.strokes[name], moves.strokes[name], rtol=0.0, atol=1e-9)
    # a cycle sums its picks, so that its depths may differ in their last bits, and makes them beside the table
    np.testing.assert_allclose(cycle.strokes["Z"], moves.strokes["Z"], rtol=0.0, atol=1e-12)
    if cycle.strokes["Z"].tobytes() == moves.strokes["Z"].tobytes():
        assert_same_strokes(moves, cycle)
    for name in ("seconds", "E", "b", "Lw"):
        assert (cycle.strokes[name] == moves.strokes[name]).all(), name
    for name in ("ae", "heq", "power", "T", "Ra", "A", "V", "ds", "W"):
        np.testing.assert_allclose(cycle.strokes[name], moves.strokes[name], rtol=1e-8, atol=1e-12, err_msg=name)
    assert not any(found for record in (cycle, tables, moves, loop) for found in record.unjudged)
