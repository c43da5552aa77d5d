"""Shop around a foreign machine: its job, its programs, its log and gauge, and the cost of its parts."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tests.foreign.laws import Flats, Laws, Loading, Machine, Threshold, Werner

OVER = 30.0  #: overrun of the table at each end of the part, mm
#: acceleration (mm/s2) and reversal time (s) of the default machine in `grind trace`
ACCELERATION, REVERSAL = 1000.0, 0.15
#: hourly rate ($/h), diamond and wheel cost of a dress ($), and time of a dress with its set-up (s)
HOURLY, EACH_DRESS, DRESS_SECONDS = 80.0, 0.2, 32.7
STALLED_SECONDS = 600.0
LOADING = 30.0
NOISE, IDLE, RATE = 25.0, 620.0, 10.0  #: noise (W), idle power (W) and sample rate (Hz) of the log


@dataclass(frozen=True, kw_only=True)
class Shop:
    """Machine and its job; lengths in mm, E in mm/min, Ra and tolerance in um, the rating in W, scrap in $."""

    name: str
    laws: Callable[[], Laws]
    length: float
    width: float
    rough: float  #: depth of the roughing block
    stock: float
    pick: float
    finish_pick: float
    sparks: int
    E: float
    finish_E: float
    rating: float
    stalls: float = 1.15  #: ratio of the stalling power to the rating
    Ra: float
    tolerance: float
    scrap: float
    burns: float  #: temperature rise at which parts burn, K

    def part(self, E: float, finish_E: float, *, dress: int = 1, cycle: str = "G82") -> str:
        """Return the blocks of one part."""
        cut = f"X{self.length + OVER:g} I-{OVER:g} Y-{self.rough:g} J-{self.pick:g}"
        return (
            f"G00 Y20.\nG00 Y5. Z-.5\nX-{OVER:g}.\nG01 Y0 F500.\n"
            f"{cycle} {cut} L0 F60. E{E:.0f} P9100 D{dress}\nM01\n"
            f"G82 Y-{self.stock:g} J-{self.finish_pick:g} L{self.sparks} F60. E{finish_E:.0f}\nG80\nG00 Y20."
        )

    def program(self, parts: Sequence[str]) -> str:
        """Return a part program of these parts."""
        each = "\nM00\n".join(parts)
        return (
            f"%\nO3001\nG71 G94 G90 G19 S1910 M03\nM08\n{each}\nM09 M05\nM30\n"
            "O9100\nG71 G90 G94\nG00 Y20.\nG00 X-120. Z-50.\nG00 Y10.\nG91 G01 Y-.02 F60.\nZ45. F191.\nY-.02 F60.\n"
            "Z-45. F191.\nG90 G00 Y20.\nM99\n%\n"
        )

    def job(self) -> str:
        """Return the text of the job file."""
        return (
            f'[part]\nmaterial = "aisi_52100"\nlength = {self.length}\nwidth = {self.width}\nheight = 20\n'
            f"stock = {self.stock}\n"
            f"roughness_limit = {self.Ra}\ntolerance = {self.tolerance}\nscrap_cost = {self.scrap}\n"
            '[setup]\nwheel = "a60j"\ndresser = "single_point"\nfluid = "emulsion"\nmachine = "default"\n'
            f"wheel_speed = 30\nmachine_overrides = {{ power_limit = {self.rating} }}\n"
            f"[times]\nload = {LOADING}\ndress_setup = 8\n"
        )

    def write(self, folder: Path) -> Path:
        """Write the job, a lot of 30 parts, one part, and a varied lot with its log and gauge; return the job file."""
        varied = [
            self.part(factor * self.E, rate * self.finish_E, dress=0, cycle=cycle)
            for factor, rate, cycle in zip(
                (1.0, 1.25, 1.5, 1.0, 0.85, 1.35, 1.15, 1.5),
                (1.0, 1.0, 0.8, 1.0, 1.3, 1.0, 1.0, 1.1),
                ("G82.1", "G82", "G82", "G82.1", "G82", "G82", "G82", "G82"),
                strict=True,
            )
        ]
        usual = self.part(self.E, self.finish_E)
        for name, parts in (("lot", [usual] * 30), ("one", [usual]), ("varied", varied)):
            (folder / f"{name}.nc").write_text(self.program(parts))
        job = folder / "job.toml"
        job.write_text(self.job())
        samples: list[tuple[float, float]] = []
        parts = list(run(self, self.machine(0), trace(folder / "varied.nc", job), samples))
        rows = "\n".join(f"{at:.1f},{power:.0f}" for at, power in samples)
        (folder / "log.csv").write_text(f"time s,spindle power W\n{rows}\n")
        gauged = [f"{k},{p.size:.1f},{p.Ra:.2f},{'yes' if p.burnt else 'no'}" for k, p in enumerate(parts, 1)]
        (folder / "gauge.csv").write_text("part,size [um],Ra [um],burn\n" + "\n".join(gauged) + "\n")
        return job

    def machine(self, seed: int) -> Machine:
        """Return the machine at the start of a shift."""
        return Machine(laws=self.laws(), width=self.width, seed=seed)


WERNER = Shop(
    name="Werner",
    laws=Werner,
    length=250.0,
    width=24.0,  # the wheel of the job is 25 mm wide
    rough=0.24,
    stock=0.28,
    pick=0.012,
    finish_pick=0.005,
    sparks=4,
    E=10000.0,
    finish_E=8000.0,
    rating=5200.0,
    Ra=0.6,
    tolerance=12.0,
    scrap=30.0,
    burns=450.0,
)
FLATS = Shop(
    name="flats",
    laws=Flats,
    length=160.0,
    width=20.0,
    rough=0.16,
    stock=0.18,
    pick=0.008,
    finish_pick=0.004,
    sparks=3,
    E=14000.0,
    finish_E=9000.0,
    rating=2400.0,
    Ra=0.4,
    tolerance=8.0,
    scrap=50.0,
    burns=310.0,
)
LOADING_WHEEL = Shop(
    name="loading",
    laws=Loading,
    length=300.0,
    width=15.0,
    rough=0.12,
    stock=0.14,
    pick=0.006,
    finish_pick=0.004,
    sparks=2,
    E=16000.0,
    finish_E=10000.0,
    rating=2600.0,
    Ra=0.5,
    tolerance=10.0,
    scrap=35.0,
    burns=450.0,
)
#: held-out machine: nothing was tuned on it, and it was tried once, at the end of the work on advice
THRESHOLD = Shop(
    name="threshold",
    laws=Threshold,
    length=200.0,
    width=18.0,
    rough=0.2,
    stock=0.225,
    pick=0.01,
    finish_pick=0.005,
    sparks=3,
    E=12000.0,
    finish_E=8000.0,
    rating=3400.0,
    Ra=0.55,
    tolerance=9.0,
    scrap=40.0,
    burns=480.0,
)
SHOPS = {shop.name: shop for shop in (WERNER, FLATS, LOADING_WHEEL, THRESHOLD)}


class Part(NamedTuple):
    """Finished part; lengths in um."""

    Ra: float
    size: float
    burnt: bool
    stalled: bool
    seconds: float
    dresses: int


class Cost(NamedTuple):
    """Cost and scrap of parts."""

    each: float  #: cost of a part with its share of scrap, $
    scrap: float  #: share of the parts


def cost(shop: Shop, parts: Sequence[Part]) -> Cost:
    """Return cost and scrap of a shift by the prices of the job."""
    bad = [part.Ra > shop.Ra or abs(part.size) > shop.tolerance or part.burnt or part.stalled for part in parts]
    seconds = sum(part.seconds + STALLED_SECONDS * part.stalled for part in parts)
    money = seconds * HOURLY / 3600.0 + EACH_DRESS * sum(part.dresses for part in parts) + shop.scrap * sum(bad)
    return Cost(money / len(parts), float(np.mean(bad)))


def grind(*words: str | Path, given: str = "") -> subprocess.CompletedProcess[str]:
    """Run the command `grind`."""
    return subprocess.run(
        [sys.executable, "-m", "grind_env", *map(str, words)], input=given, capture_output=True, text=True, check=False
    )


def trace(program: Path, job: Path) -> list[dict[str, Any]]:
    """Return the motions of a program."""
    found = grind("trace", program, "--job", job, "--strokes", "1000000")
    assert found.returncode == 0, found.stdout + found.stderr
    return [json.loads(line) for line in found.stdout.splitlines()]


def is_stroke(motion: Mapping[str, Any], before: Sequence[float]) -> bool:
    """Return whether a motion is a stroke along the table."""
    return bool(motion["source"] == "cycle" and abs(motion["end"][0] - before[0]) > OVER)


def run(
    shop: Shop, machine: Machine, motions: Sequence[Mapping[str, Any]], samples: list[tuple[float, float]] | None = None
) -> Iterator[Part]:
    """Grind with a program; yield the parts and append samples (s, W) of the power meter.

    A part begins with the slow move down to Y0.
    """
    before, part, line, dressing, now = [0.0, 20.0, 0.0], None, None, False, 0.0
    limit, peak, loading = shop.stalls * shop.rating, 0.0, 0.0
    for motion in [*motions, {"source": "end", "end": [0.0] * 3, "kind": "rapid", "seconds": 0.0}]:
        power, seconds = 0.0, motion["seconds"]
        touches = motion["kind"] == "line" and motion["source"] == "program" and motion["end"][1] == 0.0
        if motion["source"] == "dress" and not dressing:
            machine.dress()
            part = part and part._replace(dresses=part.dresses + 1, seconds=part.seconds + 8.0)
            seconds += 8.0
        dressing = motion["source"] in ("dress", "retrace")
        if (touches or motion["source"] == "end") and part:
            size = 1000.0 * (shop.stock - machine.ground)
            yield part._replace(
                Ra=machine.roughness(), size=size, burnt=machine.hottest > shop.burns, stalled=peak > limit
            )
        if touches:
            loading = machine.rng.uniform(25.0, 40.0) if samples is not None else LOADING
            machine.load()
            part, line, peak, seconds = Part(0.0, 0.0, False, False, 0.0, 0), None, 0.0, loading
        if is_stroke(motion, before):
            if line not in (None, motion["line"]):
                machine.gauge()
            line = motion["line"]
            power = machine.stroke(-motion["end"][1], motion["feed"], shop.length)
            peak = max(peak, power)
        if samples is not None:
            samples.extend(meter_samples(shop, machine.rng, motion, power, now, seconds))
        part = part and part._replace(seconds=part.seconds + motion["seconds"] + (LOADING if touches else 0.0))
        now, before = now + seconds, motion["end"]


def meter_samples(
    shop: Shop, rng: np.random.Generator, motion: Mapping[str, Any], power: float, now: float, seconds: float
) -> Iterator[tuple[float, float]]:
    """Yield the samples (s, W) of the power meter during a motion."""
    speed = motion.get("feed", 0.0) / 60.0
    cutting = shop.length / speed if power else 0.0
    middle = 0.5 * seconds
    for k in range(int(np.ceil(now * RATE)), int(np.ceil((now + seconds) * RATE))):
        at = k / RATE - now
        cuts = power * (abs(at - middle) < 0.5 * cutting)
        yield k / RATE, IDLE + cuts + NOISE * rng.standard_normal()


class Block(NamedTuple):
    """E (mm/min) and D of a block."""

    E: float
    D: int


#: function that returns E and D of a block from its number (from 0) and the readings of the block before
Decide = Callable[[int, Mapping[str, Any]], Block]


def shift(shop: Shop, depths: Sequence[Sequence[float]], decide: Decide, seed: int, parts: int = 30) -> list[Part]:
    """Grind a shift of parts block by block.

    Args:
        shop: shop with the machine.
        depths: depths of the strokes of the roughing and the finishing block, mm.
        decide: function that chooses E and D of each block.
        seed: seed of the machine.
        parts: number of parts.
    """
    machine, ground, readings = shop.machine(seed), list[Part](), dict[str, Any]()
    path = shop.length + 2.0 * OVER
    for _ in range(parts):
        machine.load()
        seconds, dresses, peak = LOADING, 0, 0.0
        for k, reached in enumerate(depths):
            E, D = decide(2 * len(ground) + k, readings)
            if k == 1:
                machine.gauge()
            at = {int((i + 1) * len(reached) / (D + 1)) for i in range(D)}
            powers = []
            for number, depth in enumerate(reached):
                if number in at:
                    machine.dress()
                powers.append(machine.stroke(depth, E, shop.length))
            dresses += D
            seconds += D * DRESS_SECONDS + len(reached) * (60.0 * path / E + E / 60.0 / ACCELERATION + REVERSAL)
            noisy = [max(round(p * (1.0 + 0.01 * machine.rng.standard_normal())), 0) for p in powers]
            cut = [p for p in noisy if p > 0] or [0]
            readings = {"mean_power": np.mean(cut[-6:]), "first_power": np.mean(cut[:4]), "peak_power": max(cut)}
            peak = max(peak, *powers)
        part = Part(
            Ra=machine.roughness(),
            size=1000.0 * (shop.stock - machine.ground),
            burnt=machine.hottest > shop.burns,
            stalled=peak > shop.stalls * shop.rating,
            seconds=seconds,
            dresses=dresses,
        )
        ground.append(part)
        readings |= {"size_error": round(part.size, 1), "Ra": round(part.Ra, 2), "burn": int(part.burnt)}
    return ground


def depths_of(program: Path, job: Path) -> list[list[float]]:
    """Return the depths of the strokes of each cycle block of a program, mm."""
    found, before = dict[int, list[float]](), [0.0] * 3
    for motion in trace(program, job):
        if is_stroke(motion, before):
            found.setdefault(motion["line"], []).append(-motion["end"][1])
        before = motion["end"]
    return [*found.values()]


def plan(shop: Shop, factor: float, every: int) -> Decide:
    """Return a fixed plan: programmed E times a factor, a dress in every `every` parts."""

    def decide(number: int, readings: Mapping[str, Any]) -> Block:
        finishing = number % 2
        return Block(factor * (shop.finish_E if finishing else shop.E), int(not finishing and number // 2 % every == 0))

    return decide


def plans(shop: Shop) -> list[Decide]:
    """Return fifteen fixed plans."""
    return [plan(shop, factor, every) for factor in (1.0, 1.5, 2.0) for every in (1, 2, 3, 5, 8)]


class PowerLaw:
    """Rule of forty lines without a model, which `grind advise` has to beat.

    Peak power is a power of E and of the ground volume, learned by recursive least squares; E is at most 1.25 times the
    last one and 88 % of the rating; a dress is due if the next part costs more than the mean part since the last dress.
    """

    def __init__(self, shop: Shop, volumes: Sequence[float]) -> None:
        self.shop, self.volumes, self.E, self.finish_E = shop, volumes, shop.E, shop.finish_E
        self.volume, self.parts, self.spent, self.beyond = 0.0, 0, 0.0, False
        self.law, self.spread = np.array([np.log(0.45 * shop.rating), 0.75, 0.2]), np.diag([0.5, 0.05, 0.03])

    def __call__(self, number: int, readings: Mapping[str, Any]) -> Block:
        """Choose E and D of a block."""
        rough, shop = self.volumes[0], self.shop
        if number % 2:
            self.learn(float(readings["peak_power"]))
            self.volume += self.volumes[1]
            return Block(self.finish_E, 0)
        if readings:
            ratio = readings["Ra"] / shop.Ra
            factor = 0.85 if ratio > 0.84 else 1.06 if ratio < 0.72 else 1.0
            self.finish_E = float(np.clip(factor * self.finish_E, 3e3, 3e4))
        most = self.E * (0.8 if self.beyond else 1.25)
        stay, new = (min(self.fastest(volume), most) for volume in (self.volume + rough, rough))
        price = EACH_DRESS + DRESS_SECONDS * HOURLY / 3600.0
        mean = (self.spent + price) / self.parts if self.parts else np.inf
        due = bool(self.parts and (self.money(stay) > mean or self.beyond))
        self.E = new if due else stay
        self.parts, self.spent = (1, self.money(new)) if due else (self.parts + 1, self.spent + self.money(stay))
        self.volume = 0.5 * rough if due else self.volume + rough
        return Block(self.E, int(due))

    def money(self, E: float) -> float:
        """Return the cost of roughing a part, $."""
        return HOURLY / 3600.0 * 60.0 * (self.shop.length + 2.0 * OVER) / E * np.ceil(self.shop.rough / self.shop.pick)

    def terms(self, E: float, volume: float) -> Any:
        """Return the terms of the law."""
        return np.array([1.0, np.log(E / self.shop.E), np.log((volume + 10.0) / 40.0)])

    def fastest(self, volume: float) -> float:
        """Return the E that the law allows, mm/min."""
        level, rate, dulling = self.law
        left = np.log(0.88 * self.shop.rating) - level - max(dulling, 0.0) * np.log((volume + 10.0) / 40.0)
        return float(np.clip(self.shop.E * np.exp(left / max(rate, 0.2)), 3e3, 3e4))

    def learn(self, peak: float) -> None:
        """Update the law with the peak power of roughing."""
        x, self.spread = self.terms(self.E, self.volume), self.spread / 0.93
        gain = self.spread @ x / (x @ self.spread @ x + 0.01)
        self.law = self.law + gain * (np.log(max(peak, 1.0)) - x @ self.law)
        self.spread = self.spread - np.outer(gain, x @ self.spread)
        self.beyond = peak > 0.97 * self.shop.rating


def volumes_of(shop: Shop) -> tuple[float, float]:
    """Return the volumes of roughing and finishing, mm3 per mm of width."""
    return shop.rough * shop.length, (shop.stock - shop.rough) * shop.length
