import itertools
from decimal import Decimal

import pytest
from hypothesis import HealthCheck, settings

from grind_env.cli import main
from grind_env.kernel import compile_at_once
from grind_env.shop.optimise import budget as clock
from grind_env.shop.optimise import variables, variation
from tests.command import Grind

# the first call of a compiled function compiles it, which no deadline should count, and a busy machine draws slowly
settings.register_profile("long", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("default", settings.get_profile("long"), max_examples=30)
settings.load_profile("default")


# compiled code is what most tests are of; what they start runs as it does for its users
compile_at_once()


@pytest.fixture
def grind(capsys: pytest.CaptureFixture[str]) -> Grind:
    """Runs a command of `grind`: exit status, output and errors."""

    def call(*words: object) -> tuple[int, str, str]:
        with pytest.raises(SystemExit) as ended:
            main([str(word) for word in words])
        said = capsys.readouterr()
        return int(ended.value.code or 0), said.out, said.err

    return call


@pytest.fixture
def few_lots(monkeypatch: pytest.MonkeyPatch) -> None:
    """Short batches are ground on as many lots as long ones, where a test is not of how sure a promise is."""
    monkeypatch.setattr(variation, "USUAL_RUNS", 1)


@pytest.fixture
def coarse_speeds(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search tries E in steps of 1 m/min, which is quicker."""
    monkeypatch.setitem(variables.STEPS, "E", (Decimal(1000), Decimal(50)))


@pytest.fixture
def clock_of_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    """The clock of a search goes on by 10 ms whenever it is looked at, however busy the machine is."""
    looks = itertools.count()
    monkeypatch.setattr(clock, "monotonic", lambda: 0.01 * next(looks))
