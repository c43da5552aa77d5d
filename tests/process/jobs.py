"""Cost per good part of two kinds of job with the prices of model.md, section 8."""

import math

from grind_env.control.cycle_formulas import motion_time
from grind_env.process.cost import Limits, Rates, running_cost, survival
from grind_env.process.stroke_types import StrokeParameters
from tests.process.harness import Grinder, grinder

RATES = Rates(hourly=80.0, wheel=1e-4, dress=0.10)


def stroke_seconds(machine: Grinder) -> float:
    return motion_time(machine.length + 60.0, machine.speed, 1000.0) + 0.15


def dress_seconds(p: StrokeParameters, passes: float) -> float:
    return 8.0 + passes * (p.bs + 10.0) / (0.10 * p.n)


def small_parts(p: StrokeParameters, table_speed: float, interval: int, passes: float = 2.0, parts: int = 240) -> float:
    """Return the cost per good part of parts of 10 strokes and 2 spark-outs, dressed before every `interval`-th one."""
    limits = Limits(rise=450.0, power=7500.0, roughness=0.40, size=8.0)
    machine = grinder(p, table_speed)
    cost = good = 0.0
    for part in range(parts):
        dressing = part % interval == 0
        volume = machine.dress(passes) if dressing else 0.0
        machine.new_part()
        strokes = machine.strokes(10, 0.010) + machine.strokes(2)
        seconds = 45.0 + 12.0 * stroke_seconds(machine) + (dress_seconds(p, passes) if dressing else 0.0)
        survived = survival(
            max(stroke.T for stroke in strokes),
            max(stroke.torque for stroke in strokes),
            machine.Rs,
            1000.0 * (machine.Z - machine.S),
            limits,
        )
        volume += sum(stroke.worn for stroke in strokes)
        cost += running_cost(seconds, volume, float(dressing), RATES) + 25.0 * (1.0 - survived)
        good += survived
    return cost / good if good > 0.0 else math.inf


def deep_cycles(
    p: StrokeParameters, table_speed: float, stock: float, executions: int, size: float, rise: float
) -> float:
    """Return the mean cost per good part of cycles 5 to 12: `stock` mm in strokes of 10 um and 4 spark-outs.

    Dresses are spaced evenly in depth. Heat counts in the last 50 um. `size` (um) and `rise` (K) are limits.
    """
    limits = Limits(rise=rise, power=7500.0, roughness=0.45, size=size)
    machine = grinder(p, table_speed)
    plunges = round(stock / 0.010)
    cost = good = 0.0
    for cycle in range(1, 13):
        machine.new_part()
        volume = hottest = strongest = 0.0
        dresses = 0
        for number in range(1, plunges + 5):
            stroke = machine.stroke(0.010 if number <= plunges else 0.0)
            volume += stroke.worn
            strongest = max(strongest, stroke.torque)
            if plunges - 5 <= number <= plunges:
                hottest = max(hottest, stroke.T)
            while dresses < executions and number * (executions + 1) >= plunges * (dresses + 1):
                volume += machine.dress()
                dresses += 1
        seconds = 20.0 + (plunges + 4) * stroke_seconds(machine) + dresses * dress_seconds(p, 2.0)
        survived = survival(hottest, strongest, machine.Rs, 1000.0 * (machine.Z - machine.S), limits)
        if cycle >= 5:
            cost += running_cost(seconds, volume, float(dresses), RATES) + 40.0 * (1.0 - survived)
            good += survived
    return cost / good if good > 0.0 else math.inf
