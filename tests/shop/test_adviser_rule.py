"""Rule of the adviser: how readings change E and D, and when the model leads."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grind_env.policies.problem_lookup import find_problem
from grind_env.shop.advise.adviser import policy_for
from grind_env.shop.advise.adviser_policy import PROVED, AdviserPolicy
from grind_env.shop.advise.operator_readings import readings_of
from grind_env.shop.advise.rehearsal import as_programmed, ground
from tests.examples import few
from tests.foreign.shop import SHOPS, PowerLaw, cost, depths_of, plans, shift, volumes_of
from tests.foreign.tools import advised_shift
from tests.shop.advising import PLATE, adviser_after, batch

ROUGHING, LIMIT = {"peak_power": 4500.0}, 7500.0


def advice_of(*rows: dict[str, Any]) -> list[tuple[float, int]]:
    adviser, advice = adviser_after(rows)
    assert adviser.advice is not None
    return [*advice, (adviser.advice.speed, adviser.advice.executions)]


def test_a_block_without_readings_keeps_its_E() -> None:
    assert {advice[0] for advice in advice_of(*[{}] * 8)} == {15_000.0, 9000.0}
    adviser, _ = adviser_after([{}] * 8)
    assert adviser.power is None and adviser.reason.startswith("dress: ")  # due by the volume alone


def test_E_rises_only_below_three_quarters_of_a_limit() -> None:
    room = advice_of(ROUGHING, {"peak_power": 1500.0, "size_error": 2.0, "Ra": 0.15}, ROUGHING)
    assert room[2][0] > 15_000.0 and room[3][0] > 9000.0
    for part in ({"size_error": 7.0}, {"Ra": 0.4}):  # the limits are 9 um and 0.5 um
        near = advice_of(ROUGHING, {"peak_power": 1500.0} | part, ROUGHING)
        assert near[2][0] <= 15_000.0 and near[3][0] <= 9000.0


def test_excess_power_calls_for_a_dress_and_then_a_lower_E() -> None:
    over = {"peak_power": 1.1 * LIMIT}
    advice = advice_of(over, {"peak_power": 1500.0}, over, {"peak_power": 1500.0})
    assert advice[2][1] >= 1 and advice[4][0] < advice[2][0] <= 15_000.0


def test_E_returns_if_a_slower_table_does_not_lower_the_power() -> None:
    over = {"peak_power": 1.1 * LIMIT}
    advice = advice_of(*[over, {"peak_power": 1500.0}] * 5)
    rough = [E for E, _ in advice[::2]]
    assert min(rough) < 0.9 * rough[0] and rough[-1] >= 0.99 * rough[0]


def test_burns_lower_E_and_reports_of_no_burn_allow_more_heat() -> None:
    finished = {"peak_power": 1500.0, "size_error": 1.0}
    burnt = advice_of(*[ROUGHING, finished | {"burn": 1}] * 5)
    rough = [E for E, _ in burnt[::2]]
    assert all(b < a for a, b in pairwise(rough))
    assert rough[-1] == pytest.approx(0.8**5 * rough[0], rel=0.01)
    assert all(D >= 1 for _, D in burnt[2::2])
    parts = [ROUGHING, finished, {"peak_power": 7400.0}]
    silent, cool = (adviser_after([*parts, finished | more])[0].policy for more in ({}, {"burn": 0}))
    assert isinstance(silent, AdviserPolicy) and isinstance(cool, AdviserPolicy)
    assert cool.rules[0].allowed[0] > 1.1 * silent.rules[0].allowed[0]


def test_a_rehearsal_reads_as_many_parts_as_burnt_as_burn(tmp_path: Path) -> None:
    soft = "[setup]\nmaterial_overrides = {tempering_rise = 100}"
    job = PLATE.with_suffix(".toml").read_text().replace("[setup]", soft)
    (tmp_path / "part.toml").write_text(job)
    simulation: Any = find_problem(str(PLATE), str(tmp_path / "part.toml"), 30).simulation()
    shifts = [ground(simulation, as_programmed(simulation), seed) for seed in range(5)]
    burnt = sum(bool(each.burn) for shift in shifts for each in shift.readings)
    assert burnt == pytest.approx(sum(shift.scrap.sum() for shift in shifts), abs=14.0)


def test_the_model_leads_only_after_its_forecasts_have_held() -> None:
    simulation: Any = batch(PLATE, 12).simulation()
    policy: Any = policy_for(None, simulation)
    stepped = list[int]()
    act = policy.model.act
    policy.model.act = lambda *given: stepped.append(1) or act(*given)
    env: Any = batch(PLATE, 12).make().unwrapped
    policy.begin(env.simulation, 1)
    observation, _ = env.reset(seed=3)
    led = []
    for _ in range(16):
        decision = policy.act(observation[None], None)
        led.append(bool(policy.leads[0]))
        if len(led) == 1:
            assert not stepped  # the first advice does not wait for the model
        observation, *_ = env.step(env.codec.encode(*decision)[0])
    assert not any(led[:PROVED]) and led[-1]
    assert "the model decides" in policy.details(0)[0]


def test_several_machines_at_once_get_the_advice_of_each_alone() -> None:
    simulation: Any = batch(PLATE, 4).simulation()
    rng = [np.random.default_rng(seed) for seed in (1, 2, 3)]
    together: Any = policy_for(None, simulation)
    together.begin(simulation, 3)
    episodes = simulation.start(rng)
    alone: list[Any] = []
    for seed in (1, 2, 3):
        policy: Any = policy_for(None, simulation)
        policy.begin(simulation, 1)
        alone.append((policy, simulation.start([np.random.default_rng(seed)])))
    for _ in simulation.blocks:
        decision = together.act(simulation.observe(episodes), None)
        simulation.step(episodes, *decision)
        for k, (policy, episode) in enumerate(alone):
            own = policy.act(simulation.observe(episode), None)
            assert (own.speeds[0], own.executions[0]) == (decision.speeds[k], decision.executions[k])
            simulation.step(episode, *own)


@pytest.mark.parametrize("seeds", few((range(100, 102), range(100, 108))))
@pytest.mark.parametrize("name", few(["flats", "loading", "Werner", "threshold"]))
def test_advice_on_a_foreign_machine_is_nearly_as_cheap_as_the_best_plan(
    name: str, seeds: range, tmp_path: Path
) -> None:
    shop = SHOPS[name]
    job = shop.write(tmp_path)
    depths = depths_of(tmp_path / "one.nc", job)
    advised = cost(shop, [p for seed in seeds for p in advised_shift(shop, tmp_path, job, seed)])
    ruled = cost(shop, [p for seed in seeds for p in shift(shop, depths, PowerLaw(shop, volumes_of(shop)), seed)])
    best = min(cost(shop, [p for seed in seeds for p in shift(shop, depths, plan, seed)]).each for plan in plans(shop))
    assert advised.each <= 1.15 * best and advised.scrap <= 0.03
    # known failures: the power law is 3 % cheaper on threshold and 2 % on loading
    assert (advised.each > 1.02 * ruled.each) == (name in {"loading", "threshold"})


def test_a_burn_reading_is_yes_or_no() -> None:
    assert readings_of({"burn": "yes"}, "here").burn is True and readings_of({"burn": 0}, "here").burn is False
