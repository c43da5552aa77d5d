import itertools
import os
from decimal import Decimal
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from grind_env.envs.task_names import environment_id, task_names
from grind_env.kernel.dispatch import Entry
from grind_env.shop.optimise import search as clock
from grind_env.shop.optimise import search_problem, variables
from grind_env.shop.possible_machines import fleet_of
from grind_env.shop.sweep import study
from tests.command import Grind, status
from tests.examples import ALL

# no deadline: the first call of a compiled function compiles it, and a busy machine draws slowly;
# no example changes a fixture that the examples of a test share
QUIET = [HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
settings.register_profile("nightly", deadline=None, suppress_health_check=QUIET, max_examples=ALL)
settings.register_profile("commit", settings.get_profile("nightly"), max_examples=10)
settings.load_profile("commit")

TASKS = ("power_limited", "wide_rails", "reciprocation", "wide_plates", "job")
ON_COMMITS = {*TASKS, *map(environment_id, TASKS)}  #: one environment of each form


#: folders of the first of two processes; the second one has all others. Each takes half of the time
FIRST_HALF = {"agents", "control", "machine", "pages", "shop", "soak"}


def pytest_ignore_collect(collection_path: Path) -> bool | None:
    """Split the tests between two processes if `make test` asks for it."""
    if "HALVES" not in os.environ or collection_path.parent != Path(__file__).parent:
        return None
    return (collection_path.name in FIRST_HALF) != (os.environ["PYTEST_XDIST_WORKER"] == "gw0") or None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark other environments as nightly in tests that also run with one of `ON_COMMITS`."""
    known = {*task_names(), *map(environment_id, task_names()), *ON_COMMITS, "grind/Task-v0"}
    taken: dict[pytest.Function, str] = {}
    for item in (each for each in items if isinstance(each, pytest.Function) and hasattr(each, "callspec")):
        values = item.callspec.params.values()
        if names := [value for value in values if isinstance(value, str) and value in known]:
            taken[item] = names[0]
    covered = {item.function for item, name in taken.items() if name in ON_COMMITS}
    for item, name in taken.items():
        if name not in ON_COMMITS and item.function in covered:
            item.add_marker(pytest.mark.nightly)


@pytest.fixture
def grind(capsys: pytest.CaptureFixture[str]) -> Grind:
    """Return a function that runs a command of `grind` and returns exit status, output and errors."""

    def call(*words: object) -> tuple[int, str, str]:
        return status(*words), *capsys.readouterr()

    return call


@pytest.fixture(autouse=True)
def two_tiers(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run small work as plain Python, as for users, even after a test that compiled at once."""
    monkeypatch.setattr(Entry, "at_once", False)


@pytest.fixture
def few_lots(monkeypatch: pytest.MonkeyPatch) -> None:
    """Simulate short batches on as few lots as long ones, for tests that do not check the confidence of a promise.

    Stop drawing possible machines once one of them grinds good parts.
    """
    monkeypatch.setattr(search_problem, "USUAL_RUNS", 1)
    for module in (search_problem, study):
        monkeypatch.setattr(module, "fleet_of", lambda *given, needed=0, **named: fleet_of(*given, needed=1, **named))


@pytest.fixture
def nothing_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compile nothing for a search, for tests that read its variables but never search."""
    monkeypatch.setattr(search_problem, "compile_all", lambda _: None)


@pytest.fixture
def coarse_speeds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a search try E in steps of 1 m/min, which is quicker."""
    monkeypatch.setitem(variables.STEPS, "E", (Decimal(1000), Decimal(50)))


@pytest.fixture
def clock_of_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Advance the clock of a search by 10 ms at every reading, however busy the machine is."""
    looks = itertools.count()
    monkeypatch.setattr(clock, "monotonic", lambda: 0.01 * next(looks))
