import pytest

from grind_env.kernel.dispatch import Entry


@pytest.fixture(autouse=True)
def compiled(two_tiers: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compile entries at their first call, because these tests are about compiled code."""
    monkeypatch.setattr(Entry, "at_once", True)
