"""Random programs that grind, with their jobs, from the whole grammar of grinding."""

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass, replace

from grind_env.machine.job import Diamond, Job, Part, PartConditions, Setup, Stage, Station, Times, WheelStart
from grind_env.process.catalogue import load_catalogue
from tests.soak.blocks import DRESSER, INCH, BlockWriter

PLANES = {"G19": "XYZ", "G17": "ZXY", "G18": "YZX"}  #: letters of the table, plunge and crossover axes
SUBPROGRAM, MACRO, CALLED = 700, 800, 9190


@dataclass(frozen=True)
class Case:
    """Program and its job."""

    seed: int  # seed of both
    text: str  # the program
    job: Job  # job that the program is ground on


def case(seed: int) -> Case:
    """Return the case of a seed."""
    return Writer(random.Random(seed)).case(seed)


class Writer(BlockWriter):
    """Writer of one case; most of its blocks are like the blocks of shops."""

    def __init__(self, rng: random.Random) -> None:
        super().__init__(rng)
        self.subprograms: dict[int, list[str]] = {}
        self.places = [""]  # blocks that lead from one station to the next

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
        if self._chance(0.12):
            self._lay_out()
        self.dress = self._chance(0.65)
        text = "\n".join(line for line in [*self._program(), *self._called()] if line) + "\n"
        if rng.random() < 0.04:
            text = self._damaged(text)
        return Case(seed, text, self.job)

    # ------------------------------------------------------------------------------------------------- the job

    def _job(self) -> Job:
        rng, catalogue, one = self.rng, load_catalogue(), self._one
        material = catalogue.material(one("aisi_52100", "aisi_52100", "aisi_1020", "inconel_718", "ti_6al_4v"))
        wheel = catalogue.wheel(one("a60j", "a60j", "a60j", "a46h", "b126"))
        machine = catalogue.machine("default")
        if self._chance(0.35):
            machine = replace(machine, power_limit=round(math.exp(self._uniform(math.log(100.0), math.log(2500.0)))))
        machine = replace(
            machine,
            stiffness=one(20_000.0, 20_000.0, 3000.0, 50_000.0),
            stall_time=one(600.0, 600.0, 0.0, 45.5),
            reversal_dwell=one(0.15, 0.15, 0.0, 0.5),
            acceleration=one(1000.0, 1000.0, 400.0),
        )
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
            height=one(20.0, 20.0, 60.0),
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
        change = one(None, None, 240.0)
        start = WheelStart(
            diameter=wheel.minimum_diameter + one(0.02, 0.2, 1.0) if self._chance(0.2) else None,
            wear_flat_area=one(None, 0.02, 0.08),
            volume_since_dress=one(None, 50.0, 400.0),
            diamond_flat=one(0.0, 0.2),
        )
        conditions = ()
        if self._chance(0.2):
            conditions = tuple(self._conditions(part) for _ in range(self.parts + (rng.random() < 0.5)))
        gauge = one(0.0, 0.0, 12.0, 1.5)
        return Job(
            part=part,
            setup=setup,
            times=Times(load=one(20.0, 0.0, 3.5), gauge=gauge, dress_setup=one(8.0, 0.0), wheel_change=change),
            wheel=start,
            diamond=self._diamond() if self._chance(0.15) else None,
            parts=conditions,
        )

    def _stages(self, stock: float) -> tuple[Stage, ...]:
        count = self._one(0, 0, 0, 1, 2)
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

    def _lay_out(self) -> None:
        """Put a second part on the table, so that each part has a station."""
        self.grooves = False
        one = self._one
        away = {
            self.along: one(20.0, 20.0, 20.0, -20.0, 8.5),
            self.down: one(0.0, 0.0, 1.0),
            self.across: one(0.0, 0.0, 0.5, 2.0),
        }  # inches, which words of both units express exactly
        x, y, z = (round(INCH * away[letter], 4) for letter in "XYZ")
        part = self.job.part
        other = replace(
            part,
            material=load_catalogue().material(one("aisi_52100", "aisi_1020")),
            stock=round(part.stock * one(1.0, 1.0, 0.8), 4),
            scrap_cost=one(part.scrap_cost, 9.0),
            stages=(),
        )
        if self._chance(0.6):
            first, second = one(("G54", "G55"), ("G59.1", "G54"))
            self.places = [first, second]
            stations = (
                Station(name="one", offset=first, part=part),
                Station(name="other", offset=second, origin=(x, y, z), part=other),
            )
        else:
            there = {"X": x, "Y": y, "Z": z}
            words = (" ".join(letter + self._length(share * there[letter]) for letter in "XYZ") for share in (0.0, 1.0))
            self.places = [f"G52 {each}" for each in words]
            other = replace(
                other,
                start=part.start + there[self.along],
                surface=part.surface + there[self.down],
                across=part.across + there[self.across],
            )
            stations = Station(name="one", part=part), Station(name="other", part=other)
        conditions = tuple(replace(each, part=None) for each in self.job.parts for _ in stations)
        self.job = replace(self.job, stations=stations, parts=conditions)

    def _diamond(self) -> Diamond:
        at = {self.along: -120.0, self.down: 10.0, self.across: -10.0}
        return Diamond(x=at["X"], y=at["Y"], z=at["Z"])

    # ------------------------------------------------------------------------------------------------- the program

    def _program(self) -> list[str]:
        lines = [self._one("", "%", "O1 (CAMPAIGN)")]
        head = f"{'G70' if self.inch else 'G71'} G94 G90 {self.plane}"
        lines.append(head + f" {self._feed(500.0)}" + self._spindle())
        lines += self._shifted() if self.places == [""] else []
        ways = [self._unrolled, self._unrolled, self._by_while, self._by_goto, self._by_subprogram, self._by_macro]
        lines += self.rng.choice(ways)()
        lines.append(self._one("M30", "M30", "M30", "M02", ""))
        return lines

    def _spindle(self) -> str:
        job = self.job
        words = ""
        if job.setup.spindle == "by program" or self._chance(0.1):
            if job.setup.constant_surface_speed and not self._odd(0.5):
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
        """Choose a work coordinate system, an offset or none; return its blocks."""
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
            system = self._one("G55", "G56", "G59.1")
            number = {"G55": 2, "G56": 3, "G59.1": 7}[system]
            return [f"G10 L2 P{number} {words}", system]
        if kind < 0.15:
            return [f"G52 {words}"]
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
        body = self._part(last=False)
        return ["#120=0", f"WHILE [#120 LT {self.parts}] DO 3", "#120=#120+1", *body, "END 3"]

    def _by_goto(self) -> list[str]:
        body = self._part(last=False)
        return ["#121=0", "N60 #121=#121+1", *body, f"IF [#121 LT {self.parts}] GOTO 60"]

    def _by_subprogram(self) -> list[str]:
        self.subprograms[SUBPROGRAM] = [*self._part(last=False), "M99"]
        return [f"M98 P{SUBPROGRAM} L{self.parts}"]

    def _by_macro(self) -> list[str]:
        self.subprograms[MACRO] = [*self._part(last=False), "M99"]
        return [f"G65 P{MACRO} A{self._length(self.job.part.length)} L{self.parts}"]

    def _part(self, last: bool) -> list[str]:
        """Write the grinding of all parts on the table, from the first approach to the end."""
        lines: list[str] = []
        for number, place in enumerate(self.places):
            lines += [*(self._lift_off() if number else []), place, *self._station_blocks()]
        return lines + self._end_of_part(last)

    def _lift_off(self) -> list[str]:
        """Stop the table and lift the wheel."""
        lines = ["G80"] if self.table.runs else []
        self.table.runs, self.height = False, self.surface + 60.0
        return [*lines, f"G00 {self._at(self.down, self.height)}"]

    def _station_blocks(self) -> list[str]:
        self.depth = 0.0
        lines = self._approach()
        for number in range(self._one(1, 1, 2, 2, 3)):
            if number and self._chance(0.5) and not self.table.runs:
                lines += self._approach()
            lines += self._cycle()
            lines += self._after_cycle()
        if self.grooves and self._chance(0.7):
            lines += self._groove()
        return lines

    def _end_of_part(self, last: bool) -> list[str]:
        lines: list[str] = []
        up = f"G00 {self._at(self.down, self.surface + 20.0)}"
        self.height = self.surface + 20.0
        if self.table.runs:
            kind = self.rng.random()
            if kind < 0.1:
                lines += ["M00", "G80"]
            elif kind < 0.17:
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
        """Write a dress program in one of the shapes that shops use."""
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
            lines += ["G91", "#30=0", "#31=1", "WHILE [#30 LT 2] DO 3", f"G01 {down}{infeed} {fast}"]
            lines += [f"{across}[{there}*#31] {slow}", "#31=-#31", "#30=#30+1", "END 3"]
        elif shape < 0.75:
            lines += [f"G91 G01 {across}{there} {slow}", f"{across}{back}"]
        elif shape < 0.82:
            lines += [f"G91 G01 {down}{infeed} {fast}", self._one("M01", "M00", "G04 P.5"), f"{across}{there} {slow}"]
        elif shape < 0.88:
            lines += ["G91", f"M98 P{CALLED}"]
        elif shape < 0.93:
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
        """Return the text with a block left out or repeated."""
        lines: Sequence[str] = text.split("\n")
        here = self.rng.randrange(len(lines))
        kept = [*lines[:here], *lines[here + 1 :]] if self._chance(0.5) else [*lines[:here], lines[here], *lines[here:]]
        return "\n".join(kept)
