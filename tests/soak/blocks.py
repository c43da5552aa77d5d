"""Blocks of random programs: approach to a part, cycles, blocks during and after cycles, grooves."""

import math
import random
from dataclasses import dataclass, field
from typing import Any

INTEGRANDS = {"X": "I", "Y": "J", "Z": "K"}
INCH = 25.4
DRESSER = 9100


@dataclass
class Table:
    """State of the table as programmed so far."""

    runs: bool = False  # whether the table reciprocates
    known: set[str] = field(default_factory=set)  # words in force, which a later cycle may omit


class BlockWriter:
    """Writer of random blocks, most of them like the blocks of shops.

    Attributes:
        job: job that the program is ground on.
        plane: G17, G18 or G19.
        along: letter of the table axis.
        down: letter of the plunge axis.
        across: letter of the crossover axis.
        inch: whether the program is in inches.
        unsettled: whether the program may have blocks that cannot be compiled to a script.
        dress: whether wheels are dressed.
        start: start of the part on the table axis, mm.
        surface: top of the part on the plunge axis, mm.
        begin: position of the table before a part, mm.
        edge: position of the wheel edge on the crossover axis, mm.
    """

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        self.table = Table()
        self.depth = 0.0  # programmed depth on the part so far, mm
        self.height = 20.0  # position of the wheel on the plunge axis, mm
        self.travel, self.goal, self.pick = 0.0, 0.0, 0.0  # travel, target and pick of the last plunge, mm
        self.lift = ""  # block to write before the next cycle
        self.loops = 0  # number of loops so far
        self.shift = (0.0, 0.0, 0.0)  # offset in force: table, plunge, crossover, mm

    def _one(self, *values: Any) -> Any:
        return self.rng.choice(values)

    def _chance(self, share: float) -> bool:
        return self.rng.random() < share

    def _odd(self, share: float) -> bool:
        """Return True with probability `share` if the program need not compile to a script."""
        return self.unsettled and self._chance(share)

    def _uniform(self, low: float, high: float) -> float:
        return self.rng.uniform(low, high)

    # --------------------------------------------------------------------------------------------- words

    def _length(self, mm: float, decimals: int = 3) -> str:
        """Return the number of a word for a length in mm, in the unit of the program."""
        text = f"{mm / INCH:.4f}" if self.inch else f"{mm:.{decimals}f}"
        text = text.rstrip("0")
        if text.startswith(("0.", "-0.")) and text not in ("0.", "-0."):
            text = text.replace("0.", ".", 1)
        return text if text not in ("-0.", "0.") else "0"

    def _at(self, letter: str, mm: float) -> str:
        """Return the word for a machine coordinate, in the coordinate system in force."""
        role = (self.along, self.down, self.across).index(letter)
        return letter + self._length(mm - self.shift[role])

    def _feed(self, mm_min: float, letter: str = "F") -> str:
        return letter + (f"{mm_min / INCH:.3f}" if self.inch else f"{mm_min:.2f}".rstrip("0"))

    def _pick(self, letter: str, mm: float) -> str:
        least = 0.0001 * INCH if self.inch else 0.001
        size = max(abs(mm), least) if mm else 0.0
        return letter + self._length(math.copysign(size, mm))

    # --------------------------------------------------------------------------------------------- approach to a part

    def _approach(self) -> list[str]:
        lines = [f"G00 {self._at(self.down, self.surface + 20.0)}"] if self._chance(0.8) else []
        begin = self._one(-30.0, -30.0, -30.0, -30.0, -5.0, -42.5)
        if self._odd(0.3):
            begin = self._one(40.0, self.job.part.length + 30.0)
        self.begin = self.start + begin
        edge = self._edge()
        lines.append(f"G00 {self._at(self.along, self.begin)} {self._at(self.across, edge)}")
        above = self._one(0.0, 0.0, 0.0, 0.01, 0.5, -0.004)
        self.height = self.surface + above - self.depth
        move = self._one("G00", "G01")
        feed = f" {self._feed(500.0)}" if move == "G01" else ""
        lines.append(f"{move} {self._at(self.down, self.height)}{feed}")
        if self._chance(0.05):
            lines.append(self._dwell())
        return lines

    def _edge(self) -> float:
        """Choose the position of the wheel edge on the crossover axis, mm."""
        part, wheel = self.job.part, self.job.setup.wheel
        cover = part.across - 0.5 * (wheel.width - part.width)
        kind = self.rng.random()
        if part.width > wheel.width:
            self.edge = part.across + self._one(0.0, 0.0, -5.0, 6.0)
        elif kind < 0.82:
            self.edge = cover
        elif kind < 0.92:
            self.edge = part.across + self._one(5.0, -7.3)
        else:
            self.edge = part.across + self._one(part.width + 10.0, -wheel.width - 10.0)
        return self.edge

    def _dwell(self, most: float = 2.5) -> str:
        return f"G04 {self._one('X', 'P')}{self._uniform(0.01, most):.2f}"

    # --------------------------------------------------------------------------------------------- cycles

    def _cycle(self) -> list[str]:
        wide = self.job.part.width > self.job.setup.wheel.width
        code = self._one(*(("G83", "G83", "G82", "G81") if wide else ("G82", "G82", "G82", "G81", "G83")))
        if self._chance(0.08):
            return self._loop_of_cycles()
        pre = self.dress and self._chance(0.18)
        words = self._table_words() + self._dress_words(code, pre)
        lines = []
        if code != "G81":
            words += self._plunge_words(code)
            lines, self.lift = [self.lift] if self.lift else [], ""
        lines.append(f"{code}{'.1' if pre else ''} {' '.join(each for each in words if each)}")
        self.table.runs = True
        if code == "G81":
            lines += self._infeeds() if self._chance(0.85) else []
        return lines

    def _table_words(self) -> list[str]:
        known, part = self.table.known, self.job.part
        far, near = self.start + part.length + 30.0, self.start - 30.0
        kind = self.rng.random()
        if self._odd(0.3):
            far, near = self._one((far, self.start + 20.0), (self.start + 0.7 * part.length, near))
        elif kind < 0.2:
            far, near = far - 25.0, near + 25.0
        elif self._odd(0.1):
            far, near = self.start - 10.0, self.start - 60.0
        elif self._odd(0.1):
            far, near = near, far
        words = []
        if "along" not in known or self._chance(0.7):
            words = [self._at(self.along, far), self._at(self.along, near).replace(self.along, INTEGRANDS[self.along])]
            if "along" in known and self._chance(0.2):
                words.pop()
        if "E" not in known or self._chance(0.7):
            words.append(self._feed(self._speed(), "E"))
        known |= {"along", "E"}
        return words

    def _speed(self) -> float:
        kind = self.rng.random()
        if kind < 0.85:
            return float(round(self._uniform(4000.0, 30_000.0)))
        # an E that the control clamps has no exact word in inches
        return self._one(400.0, 1500.0, 2999.0, 40_000.0, 50_000.0 if self.inch else 90_000.0, 60.0)

    def _dress_words(self, code: str, pre: bool) -> list[str]:
        known = self.table.known
        if not self.dress:
            return []
        words = []
        if "P" not in known or self._chance(0.5):
            words.append(f"P{DRESSER}")
            known.add("P")
        if code != "G81" and self._chance(0.45):
            words.append(f"D{self._one(0, 1, 1, 2, 3, 7)}")
        return words

    def _plunge_words(self, code: str) -> list[str]:
        known, words = self.table.known, []
        if "down" not in known or self.height < self.goal or self._chance(0.85):
            kind = self.rng.random()
            deeper = 0.0 if kind < 0.06 else round(self._uniform(0.004, 0.06), 3)
            if self._chance(0.04):
                deeper = 0.15
            target = min(self.surface - self.depth, self.height) - deeper
            if kind > 0.96 and not self.table.runs:
                self.lift, self.height = f"G00 {self._at(self.down, self.surface + 0.5)}", self.surface + 0.5
                target = self.surface + 0.3
            words.append(self._at(self.down, target))
            self.depth, self.travel = max(self.depth, self.surface - target), self.height - target
            self.height = self.goal = target
        else:
            self.travel = self.height - self.goal
            self.height = self.goal
        if "J" not in known or self.travel > 14.0 * self.pick or self._chance(0.8):
            self.pick = max(self._one(0.01, 0.01, 0.005, 0.017, 0.02, 0.05, 0.08), self.travel / 14.0)
            if self._chance(0.05):
                self.pick = 0.5
            words.append(self._pick(INTEGRANDS[self.down], -self.pick))
        if self._chance(0.25):
            words.append(self._pick("Q", -self._one(0.0, 0.004, 0.009, 0.02)))
        if self._chance(0.5):
            words.append(f"L{self._one(0, 1, 1, 2, 3)}")
        words.append(
            self._feed(
                self._one(100.0, 600.0, 600.0, 1500.0, 1500.0, 6.0 if self._odd(0.5) else 600.0)
                * (10 if code == "G83" else 1)
            )
        )
        known |= {"down", "J", "F"}
        if code == "G83":
            words += self._cross_words()
        return words

    def _cross_words(self) -> list[str]:
        part, wheel = self.job.part, self.job.setup.wheel
        if part.width > wheel.width:
            way = self._one(part.width - wheel.width, part.width - wheel.width + 8.0, 10.0)
            end = self.edge + way
        else:
            end = self.edge + self._one(2.0, 0.0, -2.0, 10.0)
        way = end - self.edge
        if self._chance(0.3):
            end, way = self.edge - way, -way
        sign = math.copysign(1.0, way)
        pick = max(self._one(3.5, 6.0, 9.2, 15.0), abs(way) / 6.0)
        words = [self._at(self.across, end), self._pick(INTEGRANDS[self.across], sign * pick)]
        if self._chance(0.4):
            words.append(self._pick("R", sign * self._one(5.0, 9.0, 0.0)))
        return words

    def _loop_of_cycles(self) -> list[str]:
        """Write a loop of ever deeper cycles on one part, with WHILE or GOTO."""
        self.loops += 1
        count, step, variable = self._one(2, 3), self._one(0.01, 0.02), 130 + self.loops
        words = [each for each in self._table_words() if each]
        self.table.known |= {"along", "E"}
        goal = f"{self.down}[{self._length(self.surface - self.shift[1] - self.depth, 4)}"
        goal += f"-#{variable}*{self._length(step, 4)}]"
        feed = self._feed(100.0)
        lines = []
        if self.height > self.surface + 0.1 or self.height < self.surface - self.depth:
            lines = [f"G00 {self._at(self.down, self.surface - self.depth)}"]
        block = f"G82 {' '.join(words)} {goal} {self._pick(INTEGRANDS[self.down], -0.01)} {feed} L0"
        body = [block, *self._one(["G80"], [], [self._dwell(0.8)], ["G80", "M01"])]
        self.depth += step * count
        self.height = self.goal = self.surface - self.depth
        self.pick = 0.01
        self.table.runs = body[-1] not in ("G80", "M01")
        self.table.known |= {"down", "J", "F"}
        if "G80" in body:
            body.append(f"G00 {self._at(self.along, self.begin)}")
            if self._chance(0.3):
                body.append(f"G00 {self._at(self.down, self.surface)}")
                self.height = self.surface
        if self._chance(0.5):
            return [
                *lines,
                f"#{variable}=0",
                f"WHILE [#{variable} LT {count}] DO 2",
                f"#{variable}=#{variable}+1",
                *body,
                "END 2",
            ]
        label = 100 + self.loops
        return [
            *lines,
            f"#{variable}=0",
            f"N{label} #{variable}=#{variable}+1",
            *body,
            f"IF [#{variable} LT {count}] GOTO {label}",
        ]

    # --------------------------------------------------------------------------------------------- during reciprocation

    def _infeeds(self) -> list[str]:
        """Write infeeds, dwells and moves during reciprocation."""
        lines = []
        if self.height > self.surface + 1.0:
            self.height = self.surface - self.depth
            lines.append(f"G00 {self._at(self.down, self.height)}")
        if self._chance(0.2):
            return lines + self._infeeds_by_loop()
        for _ in range(self._one(1, 1, 2, 3, 4)):
            kind = self.rng.random()
            if kind < 0.55:
                self.depth += self._one(0.004, 0.01, 0.02, 0.0)
                feed = self._feed(self._one(0.4, 0.8, 3.0, 60.0))
                lines.append(f"G01 {self._at(self.down, self.surface - self.depth)} {feed}")
                self.height = self.surface - self.depth
            elif kind < 0.85:
                lines.append(self._dwell())
            elif kind < 0.93:
                self.edge += self._one(3.0, -3.0, 8.0)
                move = self._one("G00", "G01")
                lines.append(f"{move} {self._at(self.across, self.edge)} {self._feed(300.0) if move == 'G01' else ''}")
            elif self._odd(1.0):
                lines.append(self._redirected())
        return lines

    def _infeeds_by_loop(self) -> list[str]:
        self.loops += 1
        variable, count, step = 150 + self.loops, self._one(2, 3, 4), self._one(0.004, 0.01)
        goal = f"{self.down}[{self._length(self.surface - self.shift[1] - self.depth, 4)}"
        goal += f"-#{variable}*{self._length(step, 4)}]"
        self.depth += step * count
        self.height = self.surface - self.depth
        move, wait = f"G01 {goal} {self._feed(self._one(0.8, 3.0))}", ""
        if self._chance(0.6):
            wait = self._dwell(1.0)
        if self._chance(0.6):
            lines = [f"#{variable}=0", f"WHILE [#{variable} LT {count}] DO 1", f"#{variable}=#{variable}+1"]
            return [*lines, move, wait, "END 1"]
        label = 200 + self.loops
        lines = [f"#{variable}=0", f"N{label} #{variable}=#{variable}+1", move, wait]
        return [*lines, f"IF [#{variable} LT {count}] GOTO {label}"]

    def _redirected(self) -> str:
        """Write another reversal point or speed for the moving table."""
        self.table.known.discard("along")
        kind = self.rng.random()
        if kind < 0.4:
            return self._feed(self._speed(), "E")
        secondary = self._at(self.along, self.start - 45.0).replace(self.along, INTEGRANDS[self.along])
        return secondary if kind < 0.7 else self._at(self.along, self.start + self.job.part.length + 40.0)

    def _after_cycle(self) -> list[str]:
        """Write blocks after a cycle, with the table moving or not."""
        lines: list[str] = []
        for _ in range(self._one(0, 1, 1, 1, 2)):
            lines += self._one_after()
        return lines

    def _one_after(self) -> list[str]:
        runs, kind = self.table.runs, self.rng.random()
        if kind < 0.22:
            self.table.runs = False
            return ["G80", *(self._by_feed_moves() if self._chance(0.25) else [])]
        if kind < 0.34:
            return [self._dwell()]
        if kind < 0.46:
            return ["M01"]
        if kind < 0.60 and runs:
            found = ["M00"]
            if self._chance(0.4):
                found.append("G80")
                self.table.runs = False
            return found
        if kind < 0.68 and runs:
            self.height = self.surface + self._one(0.3, 5.0, 20.0)
            return [f"G00 {self._at(self.down, self.height)}"]
        if kind < 0.76 and runs:
            return self._infeeds()
        if kind < 0.82:
            self.table.runs = False
            return ["G80", "M01"]
        if kind < 0.88 and not runs:
            self.height = self.surface + 20.0
            return [f"G00 {self._at(self.down, self.height)}", f"G00 {self._at(self.along, self.begin)}"]
        if kind < 0.92:
            return [self._one("M09", "M08", "S1500 M03", "M05", "G97 S1800")] if self._odd(0.8) else [""]
        if kind < 0.95:
            self.height += 0.02
            up = self._length(0.02)
            return ["G91", f"G01 {self.down}{up} {self._feed(60.0)}", "G90"]
        return []

    def _by_feed_moves(self) -> list[str]:
        """Write strokes as G01 moves, with their infeeds outside the part."""
        part, self.height = self.job.part, self.surface + 20.0
        near, far = self.start - 30.0, self.start + part.length + 30.0
        lines = [f"G00 {self._at(self.down, self.height)}", f"G00 {self._at(self.along, near)}"]
        for _ in range(self._one(1, 2, 3)):
            self.depth += self._one(0.0, 0.004, 0.02)
            lines.append(f"G01 {self._at(self.down, self.surface - self.depth)} {self._feed(500.0)}")
            ends = self._one((far,), (far, near), (far, near, far))
            if self._odd(0.3):
                ends = self._one((self.start + 0.5 * part.length, near), (far, far - 20.0), (near - 20.0,))
            lines += [f"G01 {self._at(self.along, end)} {self._feed(self._speed())}" for end in ends]
            lines += [f"G00 {self._at(self.down, self.height)}", f"G00 {self._at(self.along, near)}"]
        return lines

    # --------------------------------------------------------------------------------------------- grooves

    def _groove(self) -> list[str]:
        code = self._one("G77", "G76")
        first, second = {"G17": "XY", "G18": "ZX", "G19": "YZ"}[self.plane]
        infeed, space = (second, first) if code == "G77" else (first, second)
        lines = [] if not self.table.runs else ["G80"]
        self.table.runs = False
        top = self.surface + self._one(1.0, 0.2)
        lines.append(f"G00 {self._at(infeed, top)}")
        depth = self._one(0.05, 0.3, 1.2, -2.0)
        words = [self._at(infeed, self.surface - depth), self._pick(INTEGRANDS[infeed], 0.6), "D0"]
        if self._chance(0.5):
            words = [self._at(infeed, self.surface - depth), self._pick(INTEGRANDS[infeed], 1.5), "D.2"]
        if self._chance(0.5):
            words += [self._at(space, 14.0), INTEGRANDS[space] + self._length(7.0)]
        lines.append(f"{code} {' '.join(words)} {self._feed(self._one(0.2, 2.0, 60.0, 600.0))}")
        if self._chance(0.5):
            lines.append(lines[-1])
        lines.append(f"G00 {self._at(infeed, top)}")
        return lines
