"""The functions of paramacro expressions (D: as in the usual custom macros); angles are degrees."""

import math
from collections.abc import Callable, Mapping
from decimal import ROUND_HALF_UP, ROUND_UP, Context, Decimal

#: significant digits of angles and trigonometric values; further digits differ between processors
SIGNIFICANT_DIGITS = 14

_PRECISE = Context(prec=50)


class FunctionFault(ValueError):
    """A function without a value; the text is a sentence with the remedy."""


def _of_float(value: float) -> Decimal:
    return Decimal(f"{value:.{SIGNIFICANT_DIGITS}g}")


def _sine(angle: Decimal) -> Decimal:
    turned = float(angle % 360)
    if turned % 90.0 == 0.0:
        return Decimal((0, 1, 0, -1)[int(turned // 90.0) % 4])
    return _of_float(math.sin(math.radians(turned)))


def _tangent(angle: Decimal) -> Decimal:
    turned = float(angle % 180)
    if abs(turned) == 90.0:
        raise FunctionFault(f"TAN has no value at {angle.normalize():f} degrees; keep its angle off 90")
    return _of_float(math.tan(math.radians(turned)))


def _arc(name: str, function: Callable[[float], float]) -> Callable[[Decimal], Decimal]:
    def arc(value: Decimal) -> Decimal:
        if abs(value) > 1:
            raise FunctionFault(f"{name} of {value.normalize():f} has no value; it takes -1 to 1")
        return _of_float(math.degrees(function(float(value))))

    return arc


def arc_tangent(opposite: Decimal, adjacent: Decimal) -> Decimal:
    """Return ATAN[opposite]/[adjacent], above -180 and up to 180 degrees; with one bracket, `adjacent` is 1."""
    return _of_float(math.degrees(math.atan2(float(opposite), float(adjacent) + 0.0)))


def _root(value: Decimal) -> Decimal:
    if value < 0:
        raise FunctionFault(f"SQRT of {value.normalize():f} has no value; it takes 0 or more")
    return value.sqrt(_PRECISE)


def _logarithm(value: Decimal) -> Decimal:
    if value <= 0:
        raise FunctionFault(f"LN of {value.normalize():f} has no value; it takes more than 0")
    return value.ln(_PRECISE)


#: functions of one bracket; ATAN is not included, as it may have two
FUNCTIONS: Mapping[str, Callable[[Decimal], Decimal]] = {
    "SIN": _sine,
    "COS": lambda angle: _sine(angle + 90),
    "TAN": _tangent,
    "ASIN": _arc("ASIN", math.asin),
    "ACOS": _arc("ACOS", math.acos),
    "SQRT": _root,
    "ABS": Decimal.copy_abs,
    "ROUND": lambda value: value.to_integral_value(ROUND_HALF_UP),
    "FIX": lambda value: Decimal(int(value)),
    "FUP": lambda value: value.to_integral_value(ROUND_UP),
    "LN": _logarithm,
    "EXP": lambda value: value.exp(_PRECISE),
}
