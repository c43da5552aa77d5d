"""`grind_env.optimise` and `grind_env.sweep` refuse invalid arguments with one sentence."""

from pathlib import Path
from typing import Any

import pytest

import grind_env
from grind_env.errors import GrindError
from grind_env.shop.search_options import ends_of

PLATE = Path(grind_env.__file__).parent / "examples" / "plate_g82.nc"


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"parts": 0}, "cannot be run for 0 parts; choose --parts 1 or more"),
        ({"parts": -5}, "cannot be run for -5 parts; choose --parts 1 or more"),
        ({"seed": -1}, "the seed is -1; choose --seed 0 or more"),
        ({"vary": ()}, "--vary names no word; there are E, D"),
        ({"bounds": {"E": "5000..9000"}}, "'5000..9000' is no range of E; give its lowest and its highest"),
        ({"bounds": {"E": 9000}}, "9000 is no range of E"),
        ({"bounds": {"E": (5000, float("inf"))}}, "is no range of E"),
        ({"bounds": {"E": (float("nan"), 5000)}}, "is no range of E"),
        ({"bounds": {"E": (5, 25)}}, r"E is in mm/min; did you mean 5000\.\.25000\?"),
        ({"bounds": {"E": (9000, 8000)}}, r"begins above its end; write 8000\.\.9000"),
        ({"fix": ["N80"]}, "--fix: 'N80' is no N word; give its number"),
        ({"budget": "2min"}, "--budget: '2min' is no time; give the seconds"),
        ({"budget": -1}, "--budget: -1 is no time"),
    ],
)
def test_optimise_and_sweep_refuse_invalid_arguments(asked: dict[str, Any], said: str) -> None:
    with pytest.raises(GrindError, match=said):
        grind_env.optimise(PLATE, **{"budget": 1, **asked})
    if {*asked} & {"bounds", "parts", "seed"}:
        with pytest.raises(GrindError, match=said):
            grind_env.sweep(PLATE, **asked.get("bounds", asked))


def test_an_E_range_of_50_to_90_is_accepted_as_mm_per_min() -> None:
    assert ends_of("--bounds", "E", (50, 90)) == (50, 90)
