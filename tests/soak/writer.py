"""Writes random programs that grind, each with the job that it is ground on, from the whole grammar that grinds."""

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from grind_env.machine.job import Diamond, Job, Part, PartConditions, Setup, Stage, Times, WheelStart
from grind_env.process.catalogue import load_catalogue

PLANES = {"G19": "XYZ", "G17": "ZXY", "G18": "YZX"}
"""The letters of the table, of the plunge and of the crossover."""
INTEGRANDS = {"X": "I", "Y": "J", "Z": "K"}
INCH = 25.4
SUBPROGRAM, MACRO, DRESSER, CALLED = 700, 800, 9100, 9190


@dataclass(frozen=True)
class Case:
    """A program and its job.

    Attributes:
        seed: from which both follow.
        text: the program.
        job: what it is ground on.
        constructs: what stands in it, by name.
    """

    seed: int
    text: str
    job: Job
    constructs: frozenset[str]


@dataclass
class Table:
    """What the program has said to the table.

    Attributes:
        runs: whether it reciprocates.
        known: letters that a later cycle may leave out.
    """

    runs: bool = False
    known: set[str] = field(default_factory=set)


def case(seed: int) -> Case:
    """The case of a seed."""
    return Writer(random.Random(seed)).case(seed)


class Writer:
    """Writes one case; most of its blocks are such as shops write."""

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        self.constructs: set[str] = set()
        self.table = Table()
        self.depth = 0.0  # to which the program has led on the part, mm
        self.height = 20.0  # where the wheel stands, mm
        self.way, self.goal, self.pick = 0.0, 0.0, 0.0  # of the last plunge, mm
        self.lift = ""  # block before the coming cycle
        self.gone = 0  # loops so far
        self.shift = (0.0, 0.0, 0.0)  # of the coordinates in force: along the table, in depth, across
        self.subprograms: dict[int, list[str]] = {}

    def case(self, seed: int) -> Case:
        """Draw job and program."""
        rng = self.rng
        self.unsettled = self._chance(0.4)
        self.plane = self._one("G19", "G19", "G19", "G17", "G18")
        self.along, self.down, self.across = PLANES[self.plane]
        self.inch = self._chance(0.15)
        self.parts = self._one(1, 1, 1, 2, 2, 3)
        self.grooves = self._odd(0.3)
        self.job = self._job()
        self.start, self.surface = self.job.part.start, self.job.part.surface
        if self.inch:
            self.constructs.add("inch")
        self.constructs.add(self.plane)
        self.dress = self._chance(0.65)
        text = "\n".join(line for line in [*self._program(), *self._called()] if line) + "\n"
        if rng.random() < 0.04:
            text = self._damaged(text)
        return Case(seed, text, self.job, frozenset(self.constructs))

    def _one(self, *values: Any) -> Any:
        return self.rng.choice(values)

    def _chance(self, share: float) -> bool:
        return self.rng.random() < share

    def _odd(self, share: float) -> bool:
        """Chance of what leaves no script of the program, in those that may have it."""
        return self.unsettled and self._chance(share)

    def _uniform(self, low: float, high: float) -> float:
        return self.rng.uniform(low, high)

    def _saw(self, construct: str) -> None:
        self.constructs.add(construct)

    # ------------------------------------------------------------------------------------------------- the job

    def _job(self) -> Job:
        rng, catalogue, one = self.rng, load_catalogue(), self._one
        material = catalogue.material(one("aisi_52100", "aisi_52100", "aisi_1020", "inconel_718", "ti_6al_4v"))
        wheel = catalogue.wheel(one("a60j", "a60j", "a60j", "a46h", "b126"))
        machine = catalogue.machine("default")
        if self._chance(0.35):
            self._saw("weak spindle")
            machine = replace(machine, power_limit=round(math.exp(self._uniform(math.log(100.0), math.log(2500.0)))))
        machine = replace(
            machine,
            stiffness=one(20_000.0, 20_000.0, 3000.0, 50_000.0),
            stall_time=one(600.0, 600.0, 0.0, 45.5),
            reversal_dwell=one(0.15, 0.15, 0.0, 0.5),
            acceleration=one(1000.0, 1000.0, 400.0),
        )
        if machine.stiffness < 20_000.0:
            self._saw("soft machine")
        stock = one(0.1, 0.05, 0.03, 0.2)
        part = Part(
            material=material,
            length=one(200.0, 200.0, 80.0, 133.3),
            width=one(20.0, 20.0, 8.0, 24.6, 40.0, 55.5),
            stock=stock,
            start=one(0.0, 0.0, 0.0, 12.5),
            across=one(0.0, 0.0, -4.2),
            surface=one(0.0, 0.0, 0.0, 0.25, -0.013),
            roughness_limit=one(0.0, 0.4, 0.8),
            tolerance=one(0.0, 9.0, 30.0),
            scrap_cost=one(40.0, 0.0),
            rise_allowance=one(0.0, 0.0, 60.0, 300.0),
            stages=self._stages(stock),
        )
        setup = Setup(
            wheel=wheel,
            dresser=catalogue.dresser(one("single_point", "single_point", "blade", "rotary")),
            fluid=catalogue.fluid(one("emulsion", "emulsion", "oil")),
            machine=machine,
            wheel_speed=one(30.0, 30.0, 25.0),
            constant_surface_speed=self._chance(0.15),
            spindle=one("always on", "always on", "by program"),
            coolant=one("always on", "always on", "by program"),
            dresser_infeed=one(None, 0.03),
            grooving_wheel=self._chance(0.6),
        )
        if setup.spindle == "by program":
            self._saw("S and M03")
        change = one(None, None, 240.0)
        start = WheelStart(
            diameter=wheel.minimum_diameter + one(0.02, 0.2, 1.0) if self._chance(0.2) else None,
            wear_flat_area=one(None, 0.02, 0.08),
            volume_since_dress=one(None, 50.0, 400.0),
            diamond_flat=one(0.0, 0.2),
        )
        if change is not None and start.diameter is not None:
            self._saw("wheel change")
        conditions = ()
        if self._chance(0.2):
            self._saw("part conditions")
            conditions = tuple(self._conditions(part) for _ in range(self.parts + (rng.random() < 0.5)))
        return Job(
            part=part,
            setup=setup,
            times=Times(load=one(20.0, 0.0, 3.5), dress_setup=one(8.0, 0.0), wheel_change=change),
            wheel=start,
            diamond=self._diamond() if self._chance(0.15) else None,
            parts=conditions,
        )

    def _stages(self, stock: float) -> tuple[Stage, ...]:
        count = self._one(0, 0, 0, 1, 2)
        if count:
            self._saw("stages")
        return tuple(
            Stage(
                stock=round(stock * (k + 1) / (count + 1), 4),
                roughness_limit=self._one(0.0, 0.9),
                tolerance=self._one(0.0, 20.0),
                rise_allowance=self._one(0.0, 100.0),
            )
            for k in range(count)
        )

    def _conditions(self, part: Part) -> PartConditions:
        own = None
        if self._chance(0.2):
            own = replace(part, scrap_cost=7.0, tolerance=12.0)
        elif self._odd(0.25):
            own = replace(part, length=part.length - 20.0)
        factors = self._one({}, {"kA": 1.7}, {"ra_scale": 0.9}, {"kA": 3e3})
        stock = self._one(None, round(part.stock * self._uniform(0.7, 1.3), 4))
        return PartConditions(
            part=own, stock=stock, factors=factors, new_wheel_factors=self._one(None, None, {"kA": 0.6})
        )

    def _diamond(self) -> Diamond:
        self._saw("diamond")
        at = {self.along: -120.0, self.down: 10.0, self.across: -10.0}
        return Diamond(x=at["X"], y=at["Y"], z=at["Z"])

    # ------------------------------------------------------------------------------------------------- words

    def _length(self, mm: float, decimals: int = 3) -> str:
        """A number of a word for so many mm."""
        text = f"{mm / INCH:.4f}" if self.inch else f"{mm:.{decimals}f}"
        text = text.rstrip("0")
        if text.startswith(("0.", "-0.")) and text not in ("0.", "-0."):
            text = text.replace("0.", ".", 1)
        return text if text not in ("-0.", "0.") else "0"

    def _at(self, letter: str, mm: float) -> str:
        """A word for a coordinate of the machine, in those that are in force."""
        role = (self.along, self.down, self.across).index(letter)
        return letter + self._length(mm - self.shift[role])

    def _feed(self, mm_min: float, letter: str = "F") -> str:
        return letter + (f"{mm_min / INCH:.3f}" if self.inch else f"{mm_min:.2f}".rstrip("0"))

    def _pick(self, letter: str, mm: float) -> str:
        least = 0.0001 * INCH if self.inch else 0.001
        size = max(abs(mm), least) if mm else 0.0
        return letter + self._length(math.copysign(size, mm))

    # ------------------------------------------------------------------------------------------------- the program

    def _program(self) -> list[str]:
        lines = [self._one("", "%", "O1 (CAMPAIGN)")]
        head = f"{'G70' if self.inch else 'G71'} G94 G90 {self.plane}"
        lines.append(head + f" {self._feed(500.0)}" + self._spindle())
        lines += self._shifted()
        ways = [self._unrolled, self._unrolled, self._by_while, self._by_goto, self._by_subprogram, self._by_macro]
        lines += self.rng.choice(ways)()
        lines.append(self._one("M30", "M30", "M30", "M02", ""))
        return lines

    def _spindle(self) -> str:
        job = self.job
        words = ""
        if job.setup.spindle == "by program" or self._chance(0.1):
            if job.setup.constant_surface_speed and not self._odd(0.5):
                self._saw("G96")
                speed = job.setup.wheel_speed * 60.0
                words += f" G96 S{speed / 0.3048 if self.inch else speed:.0f} M03"
            else:
                turns = 60_000.0 * job.setup.wheel_speed / (math.pi * job.setup.wheel.diameter)
                turns *= 0.8 if self._odd(0.3) else 1.0
                words += f" S{turns:.0f} {self._one('M03', 'M03', 'M03', 'M04')}"
        if job.setup.coolant == "by program" or self._chance(0.1):
            words += "" if self._odd(0.3) else self._one(" M08", " M08", " M08", " M07")
        return words

    def _shifted(self) -> list[str]:
        """A work system, a shift or none."""
        kind = self.rng.random()
        if kind > 0.2:
            return []
        shift = [round(self._uniform(-5.0, 5.0), 1), round(self._uniform(-0.05, 0.05), 2), 0.0]
        if self.inch:
            shift = [INCH * round(each / INCH, 4) for each in shift]
        words = " ".join(
            letter + self._length(each)
            for letter, each in zip((self.along, self.down, self.across), shift, strict=True)
        )
        self.shift = (shift[0], shift[1], shift[2])
        if kind < 0.08:
            self._saw("G54 to G59.3")
            system = self._one("G55", "G56", "G59.1")
            number = {"G55": 2, "G56": 3, "G59.1": 7}[system]
            return [f"G10 L2 P{number} {words}", system]
        if kind < 0.15:
            self._saw("G52")
            return [f"G52 {words}"]
        self._saw("G92")
        self.shift = (0.0, 0.0, 0.0)
        return ["G92.1"]

    def _unrolled(self) -> list[str]:
        lines: list[str] = []
        for part in range(self.parts):
            lines += self._part(last=part + 1 == self.parts)
            if self._chance(0.05):
                lines += [self._one("", "G94", "N77 G90")]
        return lines

    def _by_while(self) -> list[str]:
        self._saw("WHILE")
        body = self._part(last=False)
        return ["#120=0", f"WHILE [#120 LT {self.parts}] DO 3", "#120=#120+1", *body, "END 3"]

    def _by_goto(self) -> list[str]:
        self._saw("GOTO")
        body = self._part(last=False)
        return ["#121=0", "N60 #121=#121+1", *body, f"IF [#121 LT {self.parts}] GOTO 60"]

    def _by_subprogram(self) -> list[str]:
        self._saw("M98")
        self.subprograms[SUBPROGRAM] = [*self._part(last=False), "M99"]
        return [f"M98 P{SUBPROGRAM} L{self.parts}"]

    def _by_macro(self) -> list[str]:
        self._saw("G65")
        self.subprograms[MACRO] = [*self._part(last=False), "M99"]
        return [f"G65 P{MACRO} A{self._length(self.job.part.length)} L{self.parts}"]

    def _part(self, last: bool) -> list[str]:
        """A part from the approach to its end."""
        self.depth = 0.0
        lines = self._approach()
        for number in range(self._one(1, 1, 2, 2, 3)):
            if number and self._chance(0.5) and not self.table.runs:
                lines += self._approach()
            if self.table.runs and number:
                self._saw("second block in a running cycle")
            lines += self._cycle()
            lines += self._after_cycle()
        if self.grooves and self._chance(0.7):
            lines += self._groove()
        lines += self._end_of_part(last)
        return lines

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
            self._saw("dwell")
            lines.append(self._dwell())
        return lines

    def _edge(self) -> float:
        """Where the edge of the wheel stands across."""
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
            self._saw("beside the part")
            self.edge = part.across + self._one(part.width + 10.0, -wheel.width - 10.0)
        return self.edge

    def _dwell(self, most: float = 2.5) -> str:
        return f"G04 {self._one('X', 'P')}{self._uniform(0.01, most):.2f}"

    # ------------------------------------------------------------------------------------------------- cycles

    def _cycle(self) -> list[str]:
        wide = self.job.part.width > self.job.setup.wheel.width
        code = self._one(*(("G83", "G83", "G82", "G81") if wide else ("G82", "G82", "G82", "G81", "G83")))
        if self._chance(0.08):
            return self._loop_of_cycles()
        pre = self.dress and self._chance(0.18)
        words = self._table_words() + self._dress_words(code, pre)
        if pre:
            self._saw(".1 form")
        self._saw(code)
        lines = []
        if code != "G81":
            words += self._plunge_words(code)
            lines, self.lift = [self.lift] if self.lift else [], ""
        lines.append(f"{code}{'.1' if pre else ''} {' '.join(each for each in words if each)}")
        self.table.runs = True
        if code == "G81":
            lines += self._fed() if self._chance(0.85) else []
        return lines

    def _table_words(self) -> list[str]:
        known, part = self.table.known, self.job.part
        far, near = self.start + part.length + 30.0, self.start - 30.0
        kind = self.rng.random()
        if self._odd(0.3):
            self._saw("strokes inside the part")
            far, near = self._one((far, self.start + 20.0), (self.start + 0.7 * part.length, near))
        elif kind < 0.2:
            far, near = far - 25.0, near + 25.0
        elif self._odd(0.1):
            self._saw("beside the part")
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
        self._saw("extreme E")
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
            self._saw("dress program")
        if code != "G81" and self._chance(0.45):
            words.append(f"D{self._one(0, 1, 1, 2, 3, 7)}")
            self._saw("D")
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
                self._saw("above the part")
                self.lift, self.height = f"G00 {self._at(self.down, self.surface + 0.5)}", self.surface + 0.5
                target = self.surface + 0.3
            words.append(self._at(self.down, target))
            self.depth, self.way = max(self.depth, self.surface - target), self.height - target
            self.height = self.goal = target
        else:
            self.way = self.height - self.goal
            self.height = self.goal
        if "J" not in known or self.way > 14.0 * self.pick or self._chance(0.8):
            self.pick = max(self._one(0.01, 0.01, 0.005, 0.017, 0.02, 0.05, 0.08), self.way / 14.0)
            if self._chance(0.05):
                self._saw("J above the depth")
                self.pick = 0.5
            words.append(self._pick(INTEGRANDS[self.down], -self.pick))
        if self._chance(0.25):
            self._saw("Q")
            words.append(self._pick("Q", -self._one(0.0, 0.004, 0.009, 0.02)))
        if self._chance(0.5):
            self._saw("L")
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
        """Cycles that go deeper in a loop within a part, by whichever way there is."""
        self.gone += 1
        count, step, variable = self._one(2, 3), self._one(0.01, 0.02), 130 + self.gone
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
        self._saw("G82")
        if "G80" in body:
            body.append(f"G00 {self._at(self.along, self.begin)}")
            if self._chance(0.3):
                body.append(f"G00 {self._at(self.down, self.surface)}")
                self.height = self.surface
        else:
            self._saw("second block in a running cycle")
        if self._chance(0.5):
            self._saw("WHILE")
            return [
                *lines,
                f"#{variable}=0",
                f"WHILE [#{variable} LT {count}] DO 2",
                f"#{variable}=#{variable}+1",
                *body,
                "END 2",
            ]
        self._saw("GOTO")
        label = 100 + self.gone
        return [
            *lines,
            f"#{variable}=0",
            f"N{label} #{variable}=#{variable}+1",
            *body,
            f"IF [#{variable} LT {count}] GOTO {label}",
        ]

    # ------------------------------------------------------------------------------------------------- beside the table

    def _fed(self) -> list[str]:
        """Infeeds, dwells and moves of the program beside the table."""
        lines = []
        if self.height > self.surface + 1.0:
            self.height = self.surface - self.depth
            lines.append(f"G00 {self._at(self.down, self.height)}")
        if self._chance(0.2):
            return lines + self._fed_by_loop()
        for _ in range(self._one(1, 1, 2, 3, 4)):
            kind = self.rng.random()
            if kind < 0.55:
                self.depth += self._one(0.004, 0.01, 0.02, 0.0)
                feed = self._feed(self._one(0.4, 0.8, 3.0, 60.0))
                lines.append(f"G01 {self._at(self.down, self.surface - self.depth)} {feed}")
                self.height = self.surface - self.depth
            elif kind < 0.85:
                self._saw("dwell")
                lines.append(self._dwell())
            elif kind < 0.93:
                self.edge += self._one(3.0, -3.0, 8.0)
                move = self._one("G00", "G01")
                lines.append(f"{move} {self._at(self.across, self.edge)} {self._feed(300.0) if move == 'G01' else ''}")
            elif self._odd(1.0):
                lines.append(self._redirected())
        return lines

    def _fed_by_loop(self) -> list[str]:
        self.gone += 1
        variable, count, step = 150 + self.gone, self._one(2, 3, 4), self._one(0.004, 0.01)
        goal = f"{self.down}[{self._length(self.surface - self.shift[1] - self.depth, 4)}"
        goal += f"-#{variable}*{self._length(step, 4)}]"
        self.depth += step * count
        self.height = self.surface - self.depth
        move, wait = f"G01 {goal} {self._feed(self._one(0.8, 3.0))}", ""
        if self._chance(0.6):
            self._saw("dwell")
            wait = self._dwell(1.0)
        if self._chance(0.6):
            self._saw("WHILE")
            lines = [f"#{variable}=0", f"WHILE [#{variable} LT {count}] DO 1", f"#{variable}=#{variable}+1"]
            return [*lines, move, wait, "END 1"]
        self._saw("GOTO")
        label = 200 + self.gone
        lines = [f"#{variable}=0", f"N{label} #{variable}=#{variable}+1", move, wait]
        return [*lines, f"IF [#{variable} LT {count}] GOTO {label}"]

    def _redirected(self) -> str:
        """Another reversal point or speed for the table under way."""
        self._saw("redirected table")
        self.table.known.discard("along")
        kind = self.rng.random()
        if kind < 0.4:
            return self._feed(self._speed(), "E")
        secondary = self._at(self.along, self.start - 45.0).replace(self.along, INTEGRANDS[self.along])
        return secondary if kind < 0.7 else self._at(self.along, self.start + self.job.part.length + 40.0)

    def _after_cycle(self) -> list[str]:
        """What comes after a cycle, with the table running or not."""
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
            self._saw("dwell")
            return [self._dwell()]
        if kind < 0.46:
            self._saw("M01 in a cycle" if runs else "M01")
            self._saw("M01")
            return ["M01"]
        if kind < 0.60 and runs:
            self._saw("M00 in a cycle")
            found = ["M00"]
            if self._chance(0.4):
                found.append("G80")
                self.table.runs = False
            return found
        if kind < 0.68 and runs:
            self._saw("wheel left above")
            self.height = self.surface + self._one(0.3, 5.0, 20.0)
            return [f"G00 {self._at(self.down, self.height)}"]
        if kind < 0.76 and runs:
            return self._fed()
        if kind < 0.82:
            self.table.runs = False
            self._saw("M01")
            return ["G80", "M01"]
        if kind < 0.88 and not runs:
            self.height = self.surface + 20.0
            return [f"G00 {self._at(self.down, self.height)}", f"G00 {self._at(self.along, self.begin)}"]
        if kind < 0.92:
            self._saw("coolant or spindle in between")
            return [self._one("M09", "M08", "S1500 M03", "M05", "G97 S1800")] if self._odd(0.8) else [""]
        if kind < 0.95:
            self._saw("G91")
            self.height += 0.02
            up = self._length(0.02)
            return ["G91", f"G01 {self.down}{up} {self._feed(60.0)}", "G90"]
        return []

    def _by_feed_moves(self) -> list[str]:
        """Strokes by the program itself, from beside the part."""
        self._saw("strokes by G01")
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

    # ------------------------------------------------------------------------------------------------- grooves, ends

    def _groove(self) -> list[str]:
        code = self._one("G77", "G76")
        first, second = {"G17": "XY", "G18": "ZX", "G19": "YZ"}[self.plane]
        infeed, space = (second, first) if code == "G77" else (first, second)
        self._saw(f"grooving by {'the wheel' if self.job.setup.grooving_wheel else 'a tool'}")
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

    def _end_of_part(self, last: bool) -> list[str]:
        lines: list[str] = []
        up = f"G00 {self._at(self.down, self.surface + 20.0)}"
        self.height = self.surface + 20.0
        if self.table.runs:
            kind = self.rng.random()
            if kind < 0.1:
                self._saw("M00 in a cycle")
                lines += ["M00", "G80"]
            elif kind < 0.17:
                self._saw("wheel left above")
                lines += [up, "G80"]
            elif kind < 0.22:
                lines += []
            else:
                lines += ["G80", up]
        else:
            lines += [up] if self._chance(0.85) else []
        self.table.runs = bool(self.table.runs and not lines)
        if not last:
            stop = self._one("M00", "M00", "M00", "M00\nM01", "M01\nM00")
            if self.table.runs:
                self._saw("M00 in a cycle")
            if "M01" in stop:
                self._saw("M01")
            lines.append(stop)
        return lines

    # ------------------------------------------------------------------------------------------------- called programs

    def _called(self) -> list[str]:
        lines: list[str] = []
        for number, body in self.subprograms.items():
            lines += [f"O{number}", *body]
        if self.dress or self._chance(0.1):
            lines += self._dresser()
        return lines

    def _dresser(self) -> list[str]:
        """A dress program, of one of the shapes that shops write."""
        unit = "G70" if self.inch else "G71"
        down, across = self.down, self.across
        high, at = 20.0, 10.0
        near = -40.0
        shape = self.rng.random()
        depth = self._one(0.02, 0.02, 0.01, 0.03)
        feed = self._one(191.0, 191.0, 120.0, 300.0)
        lines = [f"O{DRESSER}", f"{unit} G90 G94 G53 G00 {down}{self._length(high)}"]
        lines.append(f"G53 G00 {self.along}{self._length(-120.0)} {across}{self._length(near)}")
        lines.append(f"G53 G00 {down}{self._length(at)}")
        infeed, fast, slow = self._length(-depth), self._feed(60.0), self._feed(feed)
        there, back = self._length(35.0), self._length(-35.0)
        if shape < 0.55:
            lines += [f"G91 G01 {down}{infeed} {fast}", f"{across}{there} {slow}"]
            for number in range(self._one(0, 1, 1, 2)):
                lines += [f"{down}{infeed} {fast}", f"{across}{there if number % 2 else back} {slow}"]
        elif shape < 0.67:
            self._saw("dress by a loop")
            lines += ["G91", "#30=0", "#31=1", "WHILE [#30 LT 2] DO 3", f"G01 {down}{infeed} {fast}"]
            lines += [f"{across}[{there}*#31] {slow}", "#31=-#31", "#30=#30+1", "END 3"]
        elif shape < 0.75:
            self._saw("dresser advances")
            lines += [f"G91 G01 {across}{there} {slow}", f"{across}{back}"]
        elif shape < 0.82:
            self._saw("stop in a dress")
            lines += [f"G91 G01 {down}{infeed} {fast}", self._one("M01", "M00", "G04 P.5"), f"{across}{there} {slow}"]
        elif shape < 0.88:
            self._saw("dress calls")
            lines += ["G91", f"M98 P{CALLED}"]
        elif shape < 0.93:
            self._saw("dress misses or does nothing")
            lines += [f"G91 G01 {down}{infeed} {fast}", f"{across}{self._length(5.0)} {slow}"]
        else:
            lines += [f"G91 G01 {down}{infeed} {fast}", f"{across}{there} {slow}", f"G00 {down}{self._length(1.0)}"]
            lines += [f"{across}{back}", f"{down}{self._length(-1.0)}", f"G01 {down}{infeed} {fast}"]
            lines += [f"{across}{there} {slow}"]
        lines += [f"G90 G53 G00 {down}{self._length(high)}", "M99"]
        if shape >= 0.82 and shape < 0.88:
            lines += [f"O{CALLED}", f"G01 {down}{infeed} {fast}", f"{across}{there} {slow}", "M99"]
        return lines

    def _damaged(self, text: str) -> str:
        """The text with a block left out or said twice."""
        self._saw("damaged")
        lines: Sequence[str] = text.split("\n")
        here = self.rng.randrange(len(lines))
        kept = [*lines[:here], *lines[here + 1 :]] if self._chance(0.5) else [*lines[:here], lines[here], *lines[here:]]
        return "\n".join(kept)
