import pytest

from grind_env.shop.optimise import variation


@pytest.fixture
def few_lots(monkeypatch: pytest.MonkeyPatch) -> None:
    """Short batches are ground on as many lots as long ones, where a test is not of how sure a promise is."""
    monkeypatch.setattr(variation, "USUAL_RUNS", 1)
