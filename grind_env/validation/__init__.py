"""Validation of the process model: trends against expected bands, numbers against measured ones.

`python -m grind_env.validation` prints the table. `CHECKS` are its rows, `validate` computes their numbers.
"""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import MappingProxyType

from grind_env.evidence import Basis, Evidence
from grind_env.process.catalogue import Catalogue, load_catalogue
from grind_env.toml import read_toml
from grind_env.validation import declared_checks, published_checks, valve_alloys
from grind_env.validation.check import GROUPS, Band, Check, Row, row_of
from grind_env.validation.rig import Rig

__all__ = [
    "CHECKS",
    "GROUPS",
    "Band",
    "Basis",
    "Check",
    "Evidence",
    "Rig",
    "Row",
    "is_expected",
    "known_failures",
    "row_of",
    "unfit_uses",
    "validate",
]

#: all checks, by group
CHECKS: tuple[Check, ...] = tuple(
    sorted((*published_checks.CHECKS, *declared_checks.CHECKS, *valve_alloys.CHECKS), key=lambda check: check.group)
)


def validate(catalogue: Catalogue | None = None) -> list[Row]:
    """Return all checks with their numbers, for the entries of a catalogue; by default the built-in one."""
    rig = Rig(load_catalogue() if catalogue is None else catalogue)
    return [row_of(check, rig) for check in CHECKS]


@cache
def known_failures() -> Mapping[str, str]:
    """Return the known reason of each failing check, by its name."""
    return MappingProxyType(read_toml(Path(__file__).with_name("known_failures.toml"))["reasons"])


@cache
def unfit_uses() -> Mapping[str, str]:
    """Return the uses for which the model is unfit, with reasons."""
    listed = read_toml(Path(__file__).with_name("limits.toml"))["limit"]
    return MappingProxyType({each["use"]: each["why"] for each in listed})


def is_expected(row: Row) -> bool:
    """Return whether a row passes, or fails as `known_failures.toml` says."""
    return row.passed != (row.check.name in known_failures())
