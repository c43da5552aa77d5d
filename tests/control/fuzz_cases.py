"""Random programs with random settings of the control: every case follows from an integer."""

import functools
import json
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tests.control.fuzz_writer import STRAY_WORDS, Writer

SEED_FOLDERS = ("grind_env/examples", "tests/control/linuxcnc")
CHARACTERS = "GXYZIJKRQLFEPDSTMNO0123456789.-+ ()/;%[]#*\n\t\"'é\ufeff\x00"


@dataclass(frozen=True, slots=True)
class Case:
    """A program, the settings of its control, and what the operator does.

    Attributes:
        text: the part program.
        settings: keyword arguments of `Control`, as plain data.
        actions: what happens at the panel once so many events have come.
    """

    text: str
    settings: dict[str, Any] = field(default_factory=dict)
    actions: tuple[tuple[int, str], ...] = ()


def case(seed: int) -> Case:
    """The program of a seed: written by the grammar, or made from an earlier one by mutation."""
    rng = random.Random(seed)
    kind = rng.random()
    settings = _settings(rng)
    if kind < 0.65:
        text = Writer(rng).program()
    elif kind < 0.8:
        text = _mutated(rng, Writer(rng).program())
    else:
        name, text, radii = rng.choice(_seeds())
        if radii:
            settings["radii"] = dict(radii)
        if name.endswith(".ngc"):
            text = text.replace("G20", "G70").replace("G21", "G71")
        text = _mutated(rng, text)
    return Case(text, settings, _actions(rng))


def _mutated(rng: random.Random, text: str) -> str:
    """The text after a few changes of blocks, words and characters."""
    for _ in range(rng.choice([1, 1, 2, 4])):
        lines = text.split("\n")
        here, there = rng.randrange(len(lines)), rng.randrange(len(lines))
        words = lines[here].split(" ")
        spot = rng.randrange(len(words))
        change = rng.randrange(9)
        if change == 0:
            del lines[here]
        elif change == 1:
            lines.insert(there, lines[here])
        elif change == 2:
            lines[here], lines[there] = lines[there], lines[here]
        elif change == 3:
            words.insert(spot, rng.choice(STRAY_WORDS))
        elif change == 4:
            del words[spot]
        elif change == 5:
            words[spot] = words[spot][:1] + rng.choice(["0", "-1.", ".001", "99999.", "-.02", "#1", "[#2*2]", ""])
        elif change == 6:
            words[spot] = rng.choice(lines[there].split(" "))
        elif change == 7:
            lines.insert(here, " ".join(rng.choices(STRAY_WORDS, k=rng.randint(1, 4))))
        else:
            place = rng.randrange(len(text) + 1)
            text = text[:place] + rng.choice(CHARACTERS) + text[place + rng.randint(0, 1) :]
            continue
        if 3 <= change <= 6:
            lines[here] = " ".join(words)
        text = "\n".join(lines)
    return text


def _settings(rng: random.Random) -> dict[str, Any]:
    radii = {1: rng.choice([0.0, 0.5, 2.0, 5.0, -1.0]), 2: 3.0, 33: 150.0}
    settings: dict[str, Any] = {"block_budget": rng.choice([300, 1500]), "radii": radii}
    settings["variables"] = {1: 2.5, 2: -3.0, 4: 1.0}
    optional: list[tuple[str, Callable[[], Any]]] = [
        ("acceleration", lambda: rng.choice([100.0, 20000.0])),
        ("maximum_feed", lambda: rng.choice([10.0, 5000.0])),
        ("reversal_dwell", lambda: 0.15),
        ("coverage_pass", lambda: False),
        ("block_delete", lambda: True),
        ("start", lambda: (rng.uniform(-50, 50), rng.uniform(-50, 50), rng.uniform(-50, 50))),
        ("operator_dress_at", lambda: tuple(sorted(rng.uniform(0.0, 60.0) for _ in range(2)))),
        ("interrupts", lambda: _interrupts(rng)),
        ("number_format", lambda: _number_format(rng)),
        ("compensation_type", lambda: "B"),
        ("entire_wheel", lambda: True),
        ("lengths", lambda: {1: (1.0, 2.0, 3.0)}),
        ("non_motion_blocks", lambda: rng.choice([0, 1, 5])),
        ("minimum_generated_block", lambda: rng.choice([0.1, 3.0])),
        ("strict_entry_both_axes", lambda: True),
        ("work_offsets", lambda: {"G55": (10.0, -5.0, 1.0), "G59.3": (0.0, 0.0, 7.0)}),
        ("external_offset", lambda: (0.5, 0.0, -0.5)),
        ("reference_points", lambda: ((9.0, 9.0, 9.0), (50.0, 50.0, 50.0), (0.0, 0.0, 0.0), (1.0, 2.0, 3.0))),
        ("groove_retract", lambda: rng.choice([0.05, 0.25])),
        ("dress_amount", lambda: 0.02),
        ("minimum_radius", lambda: 149.97),
    ]
    return settings | {name: make() for name, make in optional if rng.random() < 0.12}


def _interrupts(rng: random.Random) -> list[dict[str, Any]]:
    times = sorted(rng.uniform(0.0, 30.0) for _ in range(rng.randint(1, 3)))
    programs = [rng.choice([9000, 9000, 9000, 9001, 100]) for _ in times]
    return [
        {"program": program, "kind": rng.choice([1, 2]), "immediate": rng.random() < 0.5, "at": time}
        for program, time in zip(programs, times, strict=True)
    ]


def _number_format(rng: random.Random) -> dict[str, Any]:
    return {
        "zero_suppression": rng.choice(["neither", "leading", "trailing"]),
        "metric": rng.choice([(5, 3), (4, 4), (3, 0), (9, 9)]),
        "excess_decimals": rng.choice(["truncate", "round"]),
    }


def _actions(rng: random.Random) -> tuple[tuple[int, str], ...]:
    if rng.random() < 0.85:
        return ()
    names = ["dress", "feedhold", "single block", "override 0", "override 150", "interrupt 1", "interrupt 2"]
    return tuple(sorted((rng.randrange(1, 40), rng.choice(names)) for _ in range(rng.randint(1, 4))))


@functools.cache
def _seeds() -> list[tuple[str, str, dict[int, float]]]:
    """Programs of the repository: name, text and radius table."""
    folder = Path(__file__).parents[2]
    index = json.loads((folder / "tests/control/linuxcnc/index.json").read_text())
    radii = {
        one["ngc"]: {int(tool): radius for tool, radius in (one.get("radii") or {}).items()} for one in index["cases"]
    }
    paths = [path for name in SEED_FOLDERS for kind in ("*.nc", "*.ngc") for path in sorted((folder / name).glob(kind))]
    return [(path.name, path.read_text(), radii.get(path.name, {})) for path in paths]
