"""What the pictures of `grind/Wen-v0` show: the setting chosen, and what it gives."""

import math

from grind_env.envs.wen.model import CASES, HIGHEST, LOWEST, Setting, WenVerdict
from grind_env.render.sheet import Entry, Sheet

UNITS = {"Vs": "m/min", "Vw": "m/min", "doc": "mm", "L": "mm per revolution"}
"""Units of a setting."""


def sheet_of(case: str, setting: Setting | None, verdict: WenVerdict | None) -> Sheet:
    """The sheet of a case with its setting and verdict; before the step there is neither."""
    title = f"Wen, Tay & Nee: {case} grinding"
    if setting is None or verdict is None:
        return Sheet(title=title, entries=(), verdict="nothing ground yet")
    asked = CASES[case]
    chosen = [
        Entry(name=f"{name}, {unit}", text=f"{value:.4g}", share=(value - low) / (high - low))
        for (name, unit), value, low, high in zip(UNITS.items(), setting, LOWEST, HIGHEST, strict=True)
    ]
    roughness, removal = verdict.roughness, verdict.removal
    results = [
        _result("Ra, um", roughness, asked.roughness_limit, beyond=roughness > asked.roughness_limit),
        _result("removal, mm3/(min N)", removal, asked.removal_floor, beyond=removal < asked.removal_floor),
        _result(
            "energy, J/mm3", verdict.energy, verdict.burn_threshold, beyond=verdict.energy > verdict.burn_threshold
        ),
    ]
    text = f"{verdict.production_cost:.2f} $ per part, objective {verdict.objective:.4f}"
    return Sheet(title=title, entries=(*chosen, *results), verdict=f"{text}, violation {verdict.violation:.4f}")


def _result(name: str, value: float, limit: float, *, beyond: bool) -> Entry:
    """A result, with a bar up to twice its limit if there is one."""
    if not 0.0 < limit < math.inf:
        return Entry(name=name, text=f"{value:.4g}", share=0.0)
    share = min(max(0.5 * value / limit, 0.0), 1.0)
    return Entry(name=name, text=f"{value:.4g}, limit {limit:.4g}", share=share, beyond=beyond)
