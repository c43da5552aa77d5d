"""Numbers of examples of a test on a commit and in the nightly job."""

from collections.abc import Iterable
from typing import Any

import pytest
from hypothesis import settings

ALL = 100  #: number of examples in the profile `nightly`


def examples(count: int) -> settings:
    """Return settings with `count` examples in the nightly job, on a commit a share of them, at least 5."""
    return settings(max_examples=max(5, count * settings().max_examples // ALL))


def nightly(*values: object) -> Any:
    """Return values of a parametrised test that only the nightly job takes."""
    return pytest.param(*values, marks=pytest.mark.nightly)


def few(values: Iterable[Any], count: int = 1) -> list[Any]:
    """Return the values of a parametrised test: commits take the first `count`, the nightly job takes the others."""
    every = [value if isinstance(value, tuple) else (value,) for value in values]
    return [pytest.param(*each, marks=() if k < count else pytest.mark.nightly) for k, each in enumerate(every)]
