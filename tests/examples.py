"""How many examples of hypothesis a test takes."""

from hypothesis import settings

ALL = 100
"""Examples of the profile `nightly`, of which a test takes as many as it states."""


def examples(count: int) -> settings:
    """Return settings with `count` examples in the nightly job, on a commit a share of them, at least 5."""
    return settings(max_examples=max(5, count * settings().max_examples // ALL))
