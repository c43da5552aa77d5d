"""Random programs with random settings of the control; a seed determines each case."""

import functools
import json
import math
import random
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from grind_env.toml import read_toml
from tests.soak.writer import case as written

SEED_FOLDERS = ("grind_env/examples", "tests/behaviour/programs", "tests/control/linuxcnc")
VOCABULARY = """
G00 G01 G02 G03 G04 G05 G07 G08 G09 G10 G17 G18 G19 G20 G28 G29 G30 G33 G39 G39.1 G40 G41 G42 G54 G59.3
G70 G71 G76 G77 G80 G81 G81.1 G82 G82.1 G83 G83.1 G84 G90 G91 G92 G92.1 G94 G95 G96 G97 M00 M01 M02 M03 M30 M98 M99 M800
M801 M900 M902 M904 X1. X-30. X0 Y-.02 Y5. Z2. Z10. I3. I0 J-.01 J0 K5. K-1. R4. R-9. Q-.01 Q0 L0 L2 L999 F60. F.1 F0
E6000. E0 S100. S0 T1 T0000 T0102 P9000 P1 P0 D2 D0 D999 N7 O9000 O1 X#1 Y[#2] Z[1/0] G[#3] X[[1+2]*#1] X[#9] M[30]
#1=#2+1 #100=#100*2 #3000=1 #5221=#5041 IF[#1EQ2]GOTO7 IF[#1GT0]THEN#2=1 GOTO8 WHILE[#1LT9]DO1 DO2 END1 END2 G65
G66 G52 G53 A1 B[#1] X[SIN[#1]] X[#1MOD#2] X#2033 Z#5043 X2.3E2 X0,2 ;remark
/ ( ) (X) % ; - . + X- X+-1 X1.. X123456. X99999. X.0001 é \x00 [ ] #
"""
STRAY_WORDS = VOCABULARY.split()
CHARACTERS = "GXYZIJKRQLFEPDSTMNO0123456789.-+ ()/;%[]#*\n\t\"'é\ufeff\x00"


@dataclass(frozen=True, slots=True)
class Case:
    """A program, the settings of its control, and what the operator does."""

    text: str  # the part program
    settings: dict[str, Any] = field(default_factory=dict)  # keyword arguments of `Control`, as plain data
    actions: tuple[tuple[int, str], ...] = ()  # what the operator does at the panel, by the number of events before it


def case(seed: int) -> Case:
    """Return the case of a seed: a random grinding program or one of the repository, in most cases mutated."""
    rng = random.Random(seed)
    settings = _settings(rng)
    if rng.random() < 0.3:
        text = written(seed).text
    else:
        text, radius = rng.choice(_seeds())
        radius *= rng.choice([1.0, 1.0, 4.0])
        settings |= {"radius": radius, "radii": {**settings["radii"], 1: radius or settings["radii"][1]}}
    if rng.random() < 0.7:
        text = _mutated(rng, text)
    if rng.random() < 0.2:
        settings["interrupts"] = _interrupts(rng, text)
    return Case(text, settings, _actions(rng))


def _mutated(rng: random.Random, text: str) -> str:
    """Return the text after a few changes of blocks, words and characters."""
    for _ in range(rng.choice([1, 1, 2, 4])):
        lines = text.split("\n")
        here, there = rng.randrange(len(lines)), rng.randrange(len(lines))
        words = lines[here].split(" ")
        spot = rng.randrange(len(words))
        change = rng.randrange(9)
        if change == 0:
            del lines[here]
        elif change == 1:
            others = rng.choice(_seeds())[0].split("\n")
            first = rng.randrange(len(others))
            lines[here:here] = others[first : first + rng.randint(1, 6)]
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
        (
            "number_format",
            lambda: {
                "zero_suppression": rng.choice(["neither", "leading", "trailing"]),
                "metric": rng.choice([(5, 3), (4, 4), (3, 0), (9, 9)]),
                "excess_decimals": rng.choice(["truncate", "round"]),
            },
        ),
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


def _interrupts(rng: random.Random, text: str) -> list[dict[str, Any]]:
    programs = [9001, *map(int, re.findall(r"^ *O(\d{1,5})\b", text, re.MULTILINE))]
    times = sorted(rng.uniform(0.0, 30.0) for _ in range(rng.randint(1, 3)))
    return [
        {"program": rng.choice(programs), "kind": rng.choice([1, 2]), "immediate": rng.random() < 0.5, "at": time}
        for time in times
    ]


def _actions(rng: random.Random) -> tuple[tuple[int, str], ...]:
    if rng.random() < 0.85:
        return ()
    names = ["dress", "feedhold", "single block", "override 0", "override 150", "interrupt 1", "interrupt 2"]
    return tuple(sorted((rng.randrange(1, 40), rng.choice(names)) for _ in range(rng.randint(1, 4))))


@functools.cache
def _seeds() -> list[tuple[str, float]]:
    """Return the programs of the repository and of the recorded messages, with their radius."""
    folder = Path(__file__).parents[2]
    index = json.loads((folder / "tests/control/linuxcnc/index.json").read_text())
    radii = {one["ngc"]: one["radius"] for one in index["cases"]}
    paths = [path for name in SEED_FOLDERS for path in sorted((folder / name).glob("*.n*c"))]
    found = [
        (path.read_text().replace("G20", "G70").replace("G21", "G71"), radii.get(path.name, 0.0)) for path in paths
    ]
    for message in read_toml(folder / "tests/control/error_texts.toml")["message"]:
        radius = message.get("settings", {}).get("radius", 0.0)
        if "program" in message and math.isfinite(radius):
            found.append((message["program"], radius))
    return found
