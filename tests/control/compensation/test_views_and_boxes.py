"""Views and boxes kept from element to element give the same results as a compensation without them."""

import random
from collections import deque

import pytest

from grind_env.control import Control, ControlError, execute, read
from grind_env.control.compensation.geometry import PathSegment
from grind_env.control.compensation.gouging import COMPARED, GougeCheck, Passed, _gouges
from grind_env.control.errors import Place
from grind_env.control.lookahead import Lookout
from tests.examples import few

#: blocks between the motions that end a view or may forbid its continuation
BETWEEN = [
    "G04 P.1",
    "M98 P200",
    "M98 P200 L3",
    "#100=#100+.5",
    "G39.1",
    "T0101",
    "T0202",
    "G55",
    "G52 X1.",
    "G40",
    "G42",
]


def program(seed: int) -> str:
    rng = random.Random(seed)
    lines = ["G71 G90 G94 G17 F600.", "#100=1.", "G41 G01 X-2. Y-5."]
    for k in range(rng.randrange(5, 60)):
        if rng.random() < 0.2:
            lines.append(rng.choice(BETWEEN))
        word = f"Y[{rng.choice([0, 1, 3])}+#100]" if rng.random() < 0.1 else f"Y{rng.choice([0.0, 0.25, 1.0, 3.0])}"
        lines.append(f"G91 G01 Y{rng.choice([1, -2])}. G90" if rng.random() < 0.1 else f"G01 X{1.5 * k} {word}")
    return "\n".join([*lines, "G40 G01 X0 Y-9.", "M30", "O200", "G91 G01 X1.", "Y2. G90", "M99"])


def events(text: str) -> list[str]:
    control = Control(radius=0.1, radii={1: 0.2, 2: 0.05}, lengths={1: (0.0, 0.0, 0.0), 2: (0.0, 0.5, 0.0)})
    found: list[str] = []
    try:
        found += map(repr, execute(read(text), control))
    except ControlError as error:
        found.append(str(error))
    return found


@pytest.mark.nightly
def test_a_continued_view_gives_the_same_events_as_a_new_one(monkeypatch: pytest.MonkeyPatch) -> None:
    went_on, has_foreseen = [0], Lookout._has_foreseen

    def counted(lookout: Lookout, outlook: object) -> bool:
        found = has_foreseen(lookout, outlook)  # type: ignore[arg-type]
        went_on[0] += found
        return found

    texts = [program(seed) for seed in range(300)]
    monkeypatch.setattr(Lookout, "_has_foreseen", counted)
    found = [events(text) for text in texts]
    monkeypatch.setattr(Lookout, "_has_foreseen", lambda lookout, outlook: False)
    assert found == [events(text) for text in texts]
    assert went_on[0] > 1000


@pytest.mark.parametrize("seed", few(range(5)))
def test_boxes_find_the_same_element_as_a_search_one_by_one(seed: int) -> None:
    rng, check = random.Random(seed), GougeCheck()
    passed, here, found = deque[Passed](maxlen=COMPARED), (0.0, 0.0), 0
    for number in range(3 * COMPARED):
        there = here[0] + rng.uniform(-3.0, 3.5), here[1] + rng.uniform(-3.0, 3.0)
        place, level = Place("p.nc", number + 1, 1, number + 1), float(rng.randrange(2))
        programmed, centre = (
            PathSegment((here[0], here[1] + 50.0), (there[0], there[1] + 50.0)),
            (PathSegment(here, there),),
        )
        new = Passed(place, programmed if rng.random() < 0.8 else PathSegment((0.0, 0.0), (1e-3, 0.0)), centre, level)
        expected = next((old.place for old in list(passed)[:-1] if _gouges(new, old)), None)
        passed.append(new)
        assert check.follow(new.place, new.programmed, centre, level) == expected
        found += expected is not None
        here = there
    assert 5 < found < 3 * COMPARED
