"""Writes random part programs by the grammar of the control."""

import math
import random
from collections.abc import Callable

PLANES = {"G17": "XYZ", "G18": "ZXY", "G19": "YZX"}
"""First axis, second axis, and the one across; the grinding cycles plunge, cross and reciprocate along them."""
INTEGRANDS = {"X": "I", "Y": "J", "Z": "K"}
SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")

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


class Writer:
    """Writes a program block by block; most of its blocks are legal where they stand."""

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        self.plane = "G18"
        self.incremental = False
        self.decimals = 3

    def program(self) -> str:
        """A main program and the programs that it calls."""
        rng = self.rng
        self.dressers = [9000 + index for index in range(rng.randint(0, 2))]
        self.subprograms = [100 + index for index in range(rng.randint(0, 2))]
        lines = ["%"] if rng.random() < 0.2 else []
        if rng.random() < 0.3:
            lines.append("O1 (MAIN)")
        lines.append(self._modes() + f" F{rng.choice(['100.', '60', '1000.', '.5'])}")
        for _ in range(rng.randint(1, 6)):
            lines += self._section()
        lines += rng.choice([["M30"], ["M30"], ["M02"], ["G80", "M30"], [], ["M99"]])
        for number in self.subprograms:
            body = [line for _ in range(rng.randint(1, 2)) for line in self._section()]
            lines += [f"O{number}", *body, rng.choice(["M99", "M99", "M99", "M30", ""])]
        for number in self.dressers:
            lines += [f"O{number} (DRESS)", *self._dress(), rng.choice(["M99"] * 9 + ["M30", ""])]
        return "\n".join(self._decorated(line) for line in lines if line) + "\n"

    def _section(self) -> list[str]:
        choices: list[tuple[Callable[[], list[str]], int]] = [
            (self._contour, 5),
            (self._moves, 3),
            (self._arcs, 3),
            (self._cycle, 5),
            (self._reciprocation, 3),
            (self._grooves, 2),
            (self._coordinates, 2),
            (self._calls, 2),
            (self._reference, 1),
            (self._expressions, 1),
            (self._loop, 1),
            (self._macro, 1),
            (self._stray, 1 if self.rng.random() < 0.3 else 0),
        ]
        writers, weights = zip(*choices, strict=True)
        (writer,) = self.rng.choices(writers, weights)
        lines: list[str] = writer()
        return lines

    def _number(self, most: float, least: float | None = None) -> str:
        least = -most if least is None else least
        value = self.rng.uniform(least, most)
        style = self.rng.random()
        if style < 0.1:
            return str(round(value))
        if style < 0.3:
            return f"{round(value)}."
        if style < 0.35:
            return "0"
        text = f"{value:.{self.rng.choice([1, 2, 3, 3, 3, 5])}f}"
        return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) and style < 0.6 else text

    def _word(self, letter: str, most: float = 50.0, least: float | None = None) -> str:
        return letter + self._number(most, least)

    def _maybe(self, chance: float, *words: str) -> str:
        return " ".join(words) if self.rng.random() < chance else ""

    def _modes(self) -> str:
        self.plane = self.rng.choice(list(PLANES))
        self.incremental = self.rng.random() < 0.2
        units = self.rng.choice(["G71", "G71", "G71", "G70"])
        self.decimals = 4 if units == "G70" else 3
        feed = "G94" if self.rng.random() < 0.97 else "S500 G95"
        return f"{units} {feed} {'G91' if self.incremental else 'G90'} {self.plane} {self._maybe(0.05, 'G08')}"

    def _moves(self) -> list[str]:
        lines = []
        for _ in range(self.rng.randint(1, 5)):
            axes = self.rng.sample("XYZ", self.rng.randint(1, 3))
            code = self.rng.choice(["G00", "G01", "", "", f"G04 P{self._number(2.0, 0.0)}", "G91", "G90"])
            words = [] if code.startswith("G04") else [self._word(axis) for axis in axes]
            extra = self._maybe(0.1, self.rng.choice(["F200.", "E3000.", "M08", "S800", "T0101", "M00", "G94 F50."]))
            lines.append(" ".join([code, *words, extra]))
        return lines

    def _arcs(self) -> list[str]:
        first, second, across = PLANES[self.plane]
        lines = [f"G90 G01 {self._word(first)} {self._word(second)}"]
        for _ in range(self.rng.randint(1, 4)):
            lines.append(self._arc(first, second, self._maybe(0.2, self._word(across))))
        return lines

    def _arc(self, first: str, second: str, extra: str) -> str:
        """An arc by centre or radius with end words that fit, counted from wherever the last block ended."""
        rng, d = self.rng, self.decimals
        radius, begin, turn = rng.uniform(1.0, 30.0), rng.uniform(0, math.tau), rng.uniform(0.05, math.tau)
        u, v = -radius * math.cos(begin), -radius * math.sin(begin)
        rotation = rng.choice([1, -1])
        end = u + radius * math.cos(begin + rotation * turn), v + radius * math.sin(begin + rotation * turn)
        code = "G03" if rotation > 0 else "G02"
        words = f"G91 {code} {first}{end[0]:.{d}f} {second}{end[1]:.{d}f}"
        if rng.random() < 0.4:
            sized = radius * rng.choice([1.0, 1.0, 1.2]) * (1 if turn < math.pi else -1)
            words += f" R{sized:.{d}f}"
        elif rng.random() < 0.1:
            words = f"G91 {code} {INTEGRANDS[first]}{u:.{d}f} {INTEGRANDS[second]}{v:.{d}f}"
        else:
            words += f" {INTEGRANDS[first]}{u:.{d}f} {INTEGRANDS[second]}{v:.{d}f}"
        return f"{words} {extra}" + ("" if self.incremental else " G90")

    def _contour(self) -> list[str]:
        """A compensated contour from entry to exit, with what may disturb it."""
        rng = self.rng
        first, second, across = PLANES[self.plane]
        side = rng.choice(["G41", "G42"])
        lines = [f"G40 G90 {rng.choice(['G00', 'G01'])} {self._word(first)} {self._word(second)}"]
        if rng.random() < 0.2:
            lines += [f"{side} T1", *(rng.choice(["M08", "G04 P.1", "", "N5"]) for _ in range(rng.randint(0, 4)))]
            side = ""
        corner = self._maybe(0.4, rng.choice(["G39", "G39.1"]))
        lines.append(f"{corner} {side} G01 {self._word(first)} {self._word(second)} {self._maybe(0.5, 'T0101')}")
        for _ in range(rng.randint(1, 7)):
            lines.append(self._compensated(first, second, across))
        lines += rng.choice([[], [], ["G40"], ["G40", "M08", "M08", "M08"], ["M30"]])
        vector = f"{self._word(INTEGRANDS[first], 5)} {self._word(INTEGRANDS[second], 5)}"
        lines.append(f"G40 G01 {self._word(first)} {self._word(second)} {self._maybe(0.2, vector)}")
        return lines

    def _compensated(self, first: str, second: str, across: str) -> str:
        rng = self.rng
        line = f"G01 {self._word(first)} {self._word(second)}"
        unusual = [
            lambda: self._word(across),
            lambda: "M08",
            lambda: "G04 P.2",
            lambda: f"T0{rng.randint(0, 3)} {line}",
            lambda: f"{rng.choice(['G41', 'G42', 'G39', 'G39.1', 'M800', 'M801'])} {line}",
            lambda: rng.choice(["G55", "G54", "G92 X1. Y2.", "G10 L2 P1 X1.", "G92.1"]),
            lambda: f"G28 {self._word(first)} {self._word(second)}",
            lambda: f"{first}0",
            lambda: self._arc(first, second, self._word(across)),
            lambda: f"/ {line}",
            lambda: rng.choice(["M98 P100", "M98 P101 L2", rng.choice(list(PLANES))]),
        ]
        kind = rng.random()
        if kind < 0.45:
            return line
        return self._arc(first, second, "") if kind < 0.75 else rng.choice(unusual)()

    def _cycle(self) -> list[str]:
        """A grinding cycle in the plane in force, sometimes without a word that it needs."""
        rng = self.rng
        plunge, cross, table = PLANES[self.plane]
        pre = self._maybe(0.2, ".1")
        code = rng.choice(["G82", "G83"])
        depth = rng.choice([0.0, 0.01, 0.05, 0.1, -0.05, -0.1, 1.0])
        pick = math.copysign(rng.choice([0.01, 0.005, 0.02, 0.002, 0.0 if rng.random() < 0.1 else 0.03]), depth)
        words = [f"{table}{self._number(200.0, 50.0)}", self._maybe(0.8, INTEGRANDS[table] + self._number(-1.0, -50.0))]
        words += [f"{plunge}{depth:.3f}", f"{INTEGRANDS[plunge]}{pick:.3f}", self._maybe(0.3, f"Q{pick / 2:.4f}")]
        if code == "G83":
            width = rng.choice([0.0, 10.0, 25.5, -20.0])
            words += [f"{cross}{width}", f"{INTEGRANDS[cross]}{math.copysign(rng.choice([5.0, 8.1, 9.0]), width)}"]
            words.append(self._maybe(0.3, f"R{math.copysign(3.0, width)}"))
        dresses = self._maybe(0.5, f"D{rng.choice([0, 1, 2, 7])}")
        words += [self._maybe(0.5, f"L{rng.choice([0, 1, 1, 2, 3, 1000])}"), self._maybe(0.9, "F60."), "E6000."]
        words += [dresses, self._program(0.9 if dresses or pre else 0.3)]
        if rng.random() < 0.1:
            words.pop(rng.randrange(len(words)))
        zero = f"G90 G00 {plunge}0 {cross}0"
        return [zero, f"{self._maybe(0.1, 'G91')} {code}{pre} {' '.join(words)}", *self._while_reciprocating(table)]

    def _program(self, chance: float) -> str:
        """The word that names a dress program, if there is one."""
        known = self.dressers or ([9000] if self.rng.random() < 0.05 else [])
        return self._maybe(chance, f"P{self.rng.choice(known)}") if known else ""

    def _reciprocation(self) -> list[str]:
        axis = self.rng.choice("XYZ")
        program = self._program(0.5)
        code = self.rng.choice(["G81", "G81.1" if program else "G81"])
        words = [axis + self._number(100.0, 10.0), self._maybe(0.8, INTEGRANDS[axis] + self._number(-1.0, -20.0))]
        return [" ".join([code, *words, program, "E9000."]), *self._while_reciprocating(axis)]

    def _while_reciprocating(self, axis: str) -> list[str]:
        rng = self.rng
        lines = []
        for _ in range(rng.randint(0, 4)):
            other = rng.choice([letter for letter in "XYZ" if letter != axis])
            lines.append(
                rng.choice(
                    [
                        f"{INTEGRANDS[axis]}{self._number(-1.0, -40.0)}",
                        f"G01 {other}{self._number(20.0)} F300.",
                        f"{axis}{self._number(90.0, 20.0)} E4000.",
                        f"G04 P{self._number(3.0, 0.0)}",
                        f"G81 {axis}{self._number(90.0, 20.0)}",
                        f"G28 {other}1.",
                        "G92 X0",
                    ]
                )
            )
        return lines + rng.choice([["G80"], ["G80"], []])

    def _grooves(self) -> list[str]:
        rng = self.rng
        first, second, _ = PLANES[self.plane]
        code = rng.choice(["G77", "G76"])
        infeed, space = (second, first) if code == "G77" else (first, second)
        words = [self._word(infeed, 20.0), INTEGRANDS[infeed] + self._number(3.0, 0.6)]
        words.append(rng.choice(["D0", "D.2", "D-.2"]))
        if rng.random() < 0.6:
            words += [self._word(space, 30.0), INTEGRANDS[space] + self._number(9.0, 1.0)]
        start = f"G40 G90 G00 {infeed}25. {space}0"
        return [self._maybe(0.9, "G80"), start, f"{code} {' '.join(words)} {self._maybe(0.5, 'F.2')}"]

    def _coordinates(self) -> list[str]:
        rng = self.rng
        return rng.sample(
            [
                f"G10 L2 P{rng.randint(1, 9)} {self._maybe(0.2, 'O2')} {self._word('X')} {self._word('Z')}",
                f"G92 {self._word('X')} {self._word('Y')}",
                rng.choice(SYSTEMS),
                "G92.1",
                f"G00 {self._word('X')} {self._word('Z')}",
                rng.choice(["G08", "G07", "G70", "G71", "G96 S1800", "G97 S1500"]),
            ],
            rng.randint(1, 4),
        )

    def _calls(self) -> list[str]:
        numbers = [*self.subprograms, *([999] if self.rng.random() < 0.05 else [])]
        times = self._maybe(0.3, f"L{self.rng.choice([0, 2, 5])}")
        return [f"M98 P{self.rng.choice(numbers)} {times}"] if numbers else []

    def _loop(self) -> list[str]:
        """A section gone through some times by one of the ways there are, or without end."""
        rng, number = self.rng, self.rng.randint(1, 3)
        count, label, body = rng.choice([0, 1, 2, 2, 9999]), rng.randint(500, 520), self._section()
        if rng.random() < 0.5:
            return [f"#{number}=0", f"WHILE [#{number} LT {count}] DO {number}", *body, f"#{number}=#{number}+1"] + (
                [f"END {number}"] if rng.random() < 0.95 else []
            )
        return [f"#{number}=0", f"N{label} #{number}=#{number}+1", *body, f"IF [#{number} LT {count}] GOTO {label}"]

    def _macro(self) -> list[str]:
        rng = self.rng
        number = rng.choice([*self.subprograms, *self.dressers, 999])
        lines = [f"G65 P{number} A{self._number(5.0)} X{self._number(5.0)} L{rng.choice([1, 2])}", "G52 X1. Z[#1+1]"]
        lines += [f"G53 G0{rng.randint(0, 1)} Z{self._number(20.0)}", f"#5{rng.choice(['221', '203', '041'])}=2.5"]
        return rng.sample(lines, rng.randint(1, 2))

    def _reference(self) -> list[str]:
        return [self.rng.choice(["G28 X1. Y2.", "G30 P3 Z4.", "G30 X1.", "G28 Z0"]), self._maybe(0.5, "G29 X3. Z2.")]

    def _expressions(self) -> list[str]:
        values = ["#1", "[#2+6]", "-#1", "[#1*[#2-3]/4]", "[1/3]", "#[1+1]", "[#4+.5]", "7."]
        if self.rng.random() < 0.2:
            values = ["[#3/0]", "[2*-3]", "#77", "[SIN[1]]", "[1+", "[[[[1]]]]", "#1.5", "#-1"]
        return [f"G{self.rng.choice(['00', '01', '[#4]'])} X{self.rng.choice(values)} Z{self.rng.choice(values)}"]

    def _dress(self) -> list[str]:
        rng = self.rng
        lines = [rng.choice(["G71 G90 G94", "G90 G00 Y30.", "M902", ""])]
        for _ in range(rng.randint(0, 5)):
            axis = rng.choice("XYZ")
            block = rng.choice([f"G00 {self._word(axis)}", f"G01 {self._word(axis)} F200.", f"G91 G01 {axis}.02 F9."])
            lines.append(rng.choice([block, block, block, "G04 P.5", self._arc("Z", "X", "G18"), "M900", "M904"]))
        if rng.random() < 0.1:
            lines += self._contour()
        return lines + ([rng.choice(["G81 X9.", "M98 P100", "G80", "G55", "G92 X1."])] if rng.random() < 0.1 else [])

    def _stray(self) -> list[str]:
        rng = self.rng
        return [" ".join(rng.choices(STRAY_WORDS, k=rng.randint(1, 4))) for _ in range(rng.randint(1, 2))]

    def _decorated(self, line: str) -> str:
        rng = self.rng
        if rng.random() < 0.1 and not line.startswith(("O", "%")):
            line = f"N{rng.randint(1, 99999)} {line}"
        if rng.random() < 0.03 and not line.startswith(("O", "%")):
            line = f"/{line}"
        return line + rng.choice(["", "", "", "", " (NOTE)", ";", " ; "])
