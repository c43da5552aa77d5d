"""A user-defined cycle, G84, runs from its rules in the interpreter and in the compiled loops.

G84 picks J at the primary point and half of J at the secondary point. After every third pick it bounces: the wheel goes
over the part once without a pick. It stands in for G82, because the grammar knows no other code.
"""

from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np
import pytest

from grind_env.control import read
from grind_env.control.cycle_formulas import DEPTH_TOLERANCE, depth_after_pick, dresses_due
from grind_env.control.cycle_planning import WORDS
from grind_env.control.cycles import RULES, Rules
from grind_env.control.events import CyclePlan
from grind_env.kernel import inlined
from grind_env.machine.loops.compiled_cycles import CYCLE_KERNELS, course_of
from grind_env.machine.loops.cycle import PartState
from grind_env.machine.loops.machine_lanes import CYCLE_FIELDS, NO_MOTIONS
from grind_env.machine.loops.stroke_loops import Loops, loops_of
from grind_env.machine.loops.zone_layout import EDGES
from grind_env.machine.record import GrindingRecord
from grind_env.machine.script.replay import BlockPlace, blocks_of
from grind_env.machine.script.script import script_of
from grind_env.machine.script.script_tables import BlockRow, PlanRow, tables_of
from grind_env.process.equations import INITIAL_ROUGHNESS
from tests.batches import FEEDS, PART, TALLY, WHEEL, as_table, cold
from tests.machine.harness import DRESS, HEAD, job, run, start_wheel, stroking


class Bounce(NamedTuple):
    """Numbers of a G84 block."""

    depth: float
    pick: float
    at_depth: float
    executions: float


class Bouncing(NamedTuple):
    """Progress of a G84 block."""

    reversal: float
    depth: float
    left: float
    dressed: float
    dresses: float


def begin(cycle: Bounce) -> Bouncing:
    """Return the progress before the first stroke."""
    return Bouncing(reversal=0.0, depth=0.0, left=cycle.at_depth, dressed=0.0, dresses=0.0)


def after_reversal(cycle: Bounce, progress: Bouncing) -> Bouncing:
    """Return the progress after the next stroke."""
    reversal = progress.reversal + 1.0
    at_depth = progress.depth >= cycle.depth
    bounces = reversal - 4.0 * np.floor(0.25 * reversal) == 0.0
    picked = depth_after_pick(reversal, progress.depth, cycle.depth, cycle.pick, 0.5 * cycle.pick)
    depth = progress.depth if at_depth | bounces else picked
    due = dresses_due(depth, cycle.depth, cycle.executions)
    return Bouncing(
        reversal=reversal,
        depth=depth,
        left=progress.left - (1.0 if at_depth else 0.0),
        dressed=due,
        dresses=due - progress.dressed,
    )


def finished(cycle: Bounce, progress: Bouncing) -> bool:
    """Return whether no stroke is left to make."""
    return (progress.depth >= cycle.depth) & (progress.left <= 0.0)


def least_strokes(cycle: Bounce) -> float:
    """Return the least number of strokes."""
    return cycle.at_depth


def of_block(plan: CyclePlan, coverage: bool) -> Bounce:
    """Return the numbers of a block."""
    return Bounce(plan.depth, plan.primary_pick, float(coverage + plan.spark_out), float(plan.dresses))


G84 = Rules(of_block, begin, after_reversal, finished, least_strokes)
COURSE = course_of(G84, Bounce, Bouncing)


@inlined
def deepest(surfaces: Any, i: int) -> float:
    """Return the depth of the deepest stroke on machine i."""
    part: float = surfaces[i, 0]
    return part


class Case(NamedTuple):
    """G84 block; depth and J in um."""

    depth: int
    J: int
    L: int
    D: int
    E: int

    @property
    def text(self) -> str:
        picks = f"Y-{self.depth / 1000:.3f} J-{self.J / 1000:.3f} L{self.L} D{self.D}"
        return f"{HEAD}G82 X230. I-30. {picks} F600. E{self.E}. P9100\nM30\n"

    def cycle(self, dress_seconds: float) -> tuple[float, ...]:
        own = {"full_plunge": self.J / 1000.0 - DEPTH_TOLERANCE, "dress_seconds": dress_seconds}
        strokes = stroking(self.E / 60.0, self.depth / 1000.0, **own)
        return *strokes, *Bounce(self.depth / 1000.0, self.J / 1000.0, 1.0 + self.L, float(self.D))

    def strokes_and_dresses(self) -> tuple[list[float], list[int]]:
        """Return the depth of every stroke, mm, and the strokes made before each dress, computed in half um."""
        h, H, J, depths, dresses = 0, 2 * self.depth, 2 * self.J, [], []
        while h < H:
            depths.append(h)
            if len(depths) % 4 > 0:
                h = min(H, h + (J if len(depths) % 2 else J // 2))
            dresses += [len(depths)] * (min(self.D, h * (self.D + 1) // H) - len(dresses))
        return [depth / 2000.0 for depth in [*depths, *[H] * (1 + self.L)]], dresses


CASES = [Case(37 + 11 * k, 6 + 5 * k % 13, k % 4, (0, 3, 1, 2)[k % 4], 6000 + 900 * k) for k in range(19)]


@pytest.fixture(scope="module")
def loops() -> Loops:
    """Return the compiled loops of G84."""
    return loops_of(COURSE)


def tables(cases: list[Case], dress_seconds: float = 30.0) -> list[Any]:
    """Return the tables that the loops read and write, up to the tallies."""
    n, p = len(cases), job().parameters
    part = PartState(0.0, 0.0, INITIAL_ROUGHNESS)
    updated = np.array([cold(start_wheel(p))] * n, WHEEL), np.array([tuple(part)] * n, PART), np.zeros(n, TALLY)
    return [np.array([case.cycle(dress_seconds) for case in cases]), np.array([p] * n), *updated]


def assert_ground(case: Case, record: GrindingRecord, parts: Any, tallies: Any) -> None:
    """Assert that one machine of the loops ends as the record of the program."""
    depths, dresses = case.strokes_and_dresses()
    (part,), (tally,) = parts, tallies
    assert (tally["strokes"], tally["dresses"]) == (len(depths), len(dresses))
    assert part["Z"] == pytest.approx(depths[-1])
    for name, made in (("peak_load", record.strokes["load"].max()), ("worn", record.strokes["worn"].sum())):
        assert tally[name] == pytest.approx(made, rel=1e-9)
    seconds = record.strokes["seconds"].sum() + record.dresses["seconds"].sum()
    assert tally["seconds"] == pytest.approx(seconds, rel=1e-12)


@pytest.mark.parametrize("case", CASES[:6])
def test_interpreter_and_compiled_loops_run_the_toy_cycle_alike(
    case: Case, loops: Loops, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(RULES, "G82", G84)
    record = run(case.text, job())
    depths, dresses = case.strokes_and_dresses()
    assert record.strokes["Z"] == pytest.approx(depths, abs=1e-12)
    assert record.dresses["after"].tolist() == dresses

    numbers = tables([case], record.dresses["seconds"][0] if dresses else 0.0)
    loops.lanes(*numbers[:2], *map(as_table, numbers[2:]), NO_MOTIONS, np.arange(1), 0, 1)
    assert_ground(case, record, *numbers[3:])


#: script as `grind_blocks` takes it
OneBlock = namedtuple("OneBlock", "blocks plans motions places cycles rows settings parameters")


def test_a_script_of_the_toy_cycle_is_replayed(loops: Loops, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(RULES, "G82", G84)
    monkeypatch.setitem(CYCLE_KERNELS, "G82", COURSE)
    grind_blocks = blocks_of({"G82": loops}, FEEDS, deepest)
    for case in CASES[:6]:
        record = run(case.text, job())
        script = tables_of(script_of(read(case.text + DRESS), job()))
        row, plan = BlockRow(*script.blocks[0]), PlanRow(*script.plans[0])
        depths = row.start, row.bottom, row.finish, row.finish_of_other_blocks, plan.depth
        places = np.array([BlockPlace(*depths, plan.pre_dress, row.motion, -1.0, 1.0, 0.15, 0.0)])
        _, parameters, wheels, parts, tallies = tables([case])
        first, room = np.zeros(1, np.int64), np.empty((1, CYCLE_FIELDS))
        one = OneBlock(*script[:2], script.motions, places, room, first, script.own_settings, parameters)
        grind_blocks(one, *map(as_table, (wheels, parts, tallies)), first)
        assert_ground(case, record, parts, tallies)


@pytest.mark.bits
def test_lanes_of_the_toy_cycle_do_not_affect_each_other(loops: Loops) -> None:
    alone, beside = tables(CASES), tables(CASES)
    for k in range(len(CASES)):
        loops.lanes(*alone[:2], *map(as_table, alone[2:]), NO_MOTIONS, np.array([k]), 0, 1)
    loops.lanes(*beside[:2], *map(as_table, beside[2:]), NO_MOTIONS, np.arange(len(CASES)), 0, 1)
    assert [table.tobytes() for table in beside] == [table.tobytes() for table in alone]
    assert (alone[4]["dresses"] == [case.D for case in CASES]).all()
    assert alone[4]["strokes"].tolist() == [len(case.strokes_and_dresses()[0]) for case in CASES]


def test_tables_of_words_kernels_and_edges_have_all_their_cycles() -> None:
    crossing = {code for code, rules in RULES.items() if rules.cross is not None}
    assert set(WORDS) == set(RULES)
    assert set(CYCLE_KERNELS) == {code for code, rules in RULES.items() if rules.plunges}
    assert set(EDGES) == crossing
