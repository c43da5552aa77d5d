"""Programs from the soak that once gave different results in different ways of running them."""

from dataclasses import replace
from typing import Any

from grind_env.machine.job import Job, PartConditions, Station, Times, WheelStart
from tests.machine.harness import CATALOGUE, DRESS, job

HEAD = "G71 G94 G90 G19\nG00 Y20.\nG00 X-30. Z-2.5\nG01 Y0 F500.\n"
CYCLE = "G82 X230. I-30. Y-.03 J-.01 L1 F600. E12000. P9100\n"  #: cycle that ends at the primary reversal point
TO_SECONDARY = CYCLE.replace("L1", "L2")
DRESSED = CYCLE.replace("P9100", "P9100 D1")
PICKED = CYCLE.replace("J-.01", "J-.05")
FED = "G81 X230. I-30. E12000.\nG01 Y-.01 F.4\nG01 Y-.02 F3.\n"
OFF = "G80\nG00 Y20.\nM00\n"
END = "G80\nG00 Y20.\nM30\n"
PLAIN = HEAD + CYCLE + END

#: dress program that leaves a variable set
LEAVING = DRESS.replace("N5 G91", "#30=7\nN5 G91").replace("O9100", "O9300")
GROOVES = "G80\nG18 G00 X20. Z0\nG77 X-2. I1. D0 F200.\nG77 X-4. I1. D0 F200.\nG00 X40.\n"


def weak(power: float, **setup: Any) -> Job:
    """Return a job with a power limit of the spindle, W."""
    machine = replace(CATALOGUE.machine("default"), power_limit=power)
    return job(tolerance=30.0, setup={"machine": machine, **setup})


def stations() -> Job:
    """Return a job with two parts on the table, and a wheel that the first dress wears out."""
    worn = replace(job(wheel_start=WheelStart(diameter=220.03)), times=Times(wheel_change=240.0))
    other = Station(name="right", offset="G55", origin=(500.0, 0.0, 0.0), part=worn.part)
    return replace(worn, stations=(Station(name="left", offset="G54", part=worn.part), other))


DEEPER = CYCLE.replace("Y-.03", "Y-.04")
STAGES = FED.replace("Y-.0", "Y-.1")
FOUND: dict[str, tuple[str, Job]] = {
    "M00 before the final G80, the table at its secondary point": (HEAD + TO_SECONDARY + "M00\n" + END, job()),
    "M00 before the final G80, the table at its primary point": (HEAD + CYCLE + "M00\n" + END, job()),
    "M00 beside infeeds": (HEAD + FED.replace("G01 Y-.02", "M00\nG01 Y-.02") + END, job()),
    "M00 and M01 beside dwells": (HEAD + CYCLE + "M00\nG04 X2.\nM01\nG04 X1.\n" + END, job()),
    "M00 where the next cycle takes over": (HEAD + CYCLE + "M00\n" + DEEPER + END, job()),
    "two parts, each taken off before G80": ((HEAD + CYCLE + "M00\nG80\nG00 Y20.\n") * 2 + "M30\n", job()),
    "a dwell after the last M00": (HEAD + CYCLE + OFF + "G04 X5.\nM30\n", job()),
    "a spindle at its power limit": (HEAD + PICKED + END, weak(900.0)),
    "a spindle that stalls, and infeeds after it": (HEAD + PICKED + STAGES + "G04 X2.\n" + END, weak(200.0)),
    "a weak spindle in a program without a script": (HEAD + PICKED.replace("I-30.", "I30.") + END, weak(900.0)),
    "heat of an earlier cycle in a program without a script": (
        HEAD + CYCLE.replace("I-30.", "I30.") + "G82 Y-.12 J-.005\n" + END,
        job(),
    ),
    "a table that never reaches E": (
        HEAD + CYCLE.replace("X230. I-30.", "X205. I-5.").replace("E12000.", "E40000.") + END,
        job(),
    ),
    "a stalled groove": (HEAD + CYCLE + GROOVES + "M30\n", weak(300.0, grooving_wheel=True)),
    "infeeds that no stroke reaches": (
        HEAD.replace("Y0 F500.", "Y-.004 F500.") + FED + "G01 Y-.04 F60.\nG01 Y-.096 F3.\n" + END,
        weak(300.0),
    ),
    "a grazing stroke": (
        HEAD.replace("Y0 F500.", "Y.487 F500.") + CYCLE.replace("J-.01", "J-.5") + END,
        job(surface=-0.013, width=40.0),
    ),
    "a cross infeed that ends at the edge of a strip": (
        HEAD.replace("Z-2.5", "Z-6.7") + FED + "G01 Z1.3 F300.\n" + END,
        job(across=-4.2),
    ),
    "a program that ends during a G81": (HEAD + CYCLE + FED, job()),
    "a reversal point that moves before the next cycle": (HEAD + FED.split("\n")[0] + "\nI-45.\n" + CYCLE + END, job()),
    "an E with decimals": (HEAD + CYCLE.replace("12000.", "12345.678") + END, job()),
    "other factors for a changed wheel": (
        (HEAD + CYCLE.replace("P9100", "P9100 D2") + OFF) * 2 + HEAD + CYCLE + END,
        replace(
            job(wheel_start=WheelStart(diameter=220.05)),
            times=Times(wheel_change=240.0),
            parts=(PartConditions(factors={"kA": 2.0}, new_wheel_factors={"kA": 0.6}),) * 3,
        ),
    ),
    "a wheel that is changed between two stations": (
        "".join(f"{offset}\n{HEAD}{DRESSED}G80\nG00 Y60.\n" for offset in ("G54", "G55")) + "M30\n",
        stations(),
    ),
    "dresses that leave variables set": ((HEAD + CYCLE + DEEPER + END + LEAVING).replace("P9100", "P9300"), job()),
    "dresses that make a wheel too small": (
        HEAD + DRESSED + OFF + HEAD + CYCLE.replace("P9100", "P9100 D3") + END,
        job(wheel_start=WheelStart(diameter=220.1)),
    ),
    "a wheel that wears away completely": (
        HEAD + CYCLE.replace("Y-.03 J-.01", "Y-9. J-3.") + CYCLE.replace("Y-.03 J-.01", "Y-19. J-3.") + END,
        job(stock=0.2),
    ),
}
