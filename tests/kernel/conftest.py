import pytest

from grind_env.kernel.dispatch import Entry


@pytest.fixture(autouse=True)
def compiled(two_tiers: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Entries are compiled at their first call: compiled code is what these tests are about."""
    monkeypatch.setattr(Entry, "at_once", True)
