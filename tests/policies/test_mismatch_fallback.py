from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from grind_env.belief.wheel_belief import Forecast
from grind_env.envs.blocks.task_simulation import BlockSimulation
from grind_env.envs.tasks import load_task
from grind_env.policies import guarded
from grind_env.policies.evaluation import cost_per_good_part, episode_seeds, roll_out, run_seeds, start_episodes
from grind_env.policies.mismatch_alarms import Watch
from grind_env.policies.mismatch_fallback import Guarded
from grind_env.policies.policy_lookup import named_policy
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.registry import ConfigError
from grind_env.policies.scripted.learned_laws import PowerLaw
from grind_env.policies.scripted.rules import Fixed
from tests.policies.harness import observation, shortened, simulated

PLATES = simulated("power_limited")
USUAL = {"mean_power": 4000.0, "peak_power": 4500.0, "size_error": 5.0, "roughness": 0.5}


def watched(
    *read: dict[str, float],
    peak: float = 4500.0,
    size: float = 5.0,
    spread: float = 0.0,
    heat: float = 0.5,
    residual: float = 0.0,
) -> tuple[Watch, list[bool]]:
    """Return a watch with a constant forecast after these readings, and for each reading whether it alarmed."""
    watch, law = Watch(PLATES, 1, residual), PowerLaw(1)
    members = np.array([[-1.0, 1.0]]) * spread
    made = Forecast(
        4000.0 * np.exp(members),
        peak * np.exp(members),
        size + 10.0 * members,
        np.full((1, 2), 0.5),
        np.full((1, 2), heat),
    )
    watch.belief = SimpleNamespace(update=lambda seen: None, forecast=made)
    watch.update(observation(PLATES), law)
    alarms = []
    for k, each in enumerate(read):
        row = USUAL | each
        # no two parts are gauged exactly alike
        watch.update(observation(PLATES, **(row | {"size_error": row["size_error"] + 1e-3 * (k % 2)})), law)
        alarms.append(bool(watch.alarm[0]))
    return watch, alarms


def test_readings_as_forecast_raise_no_alarm() -> None:
    watch, alarms = watched(*[{}] * 50)
    assert not any(alarms)
    assert watch.holds.tolist() == [True]
    assert watch.said(0) == []


def test_a_power_within_the_calibration_residual_raises_no_alarm() -> None:
    run = [{"peak_power": 6500.0}] * 12
    assert any(watched({}, *run, peak=5000.0)[1]) and not any(watched({}, *run, peak=5000.0, residual=0.5)[1])


def test_one_unexpected_reading_beyond_a_limit_raises_an_alarm_with_a_reason() -> None:
    watch, alarms = watched({}, {"size_error": -21.0}, size=-5.0)
    assert alarms == [False, True]
    # a forecast of -5 um, and a spread of hypot(0.7, 0.5) = 0.86 um; the first reading was off by 10 outward
    assert watch.said(0) == ["size error -21.00 um, where -0.86 to 0.86 was forecast; the limit is -20.00"]
    assert watched({"peak_power": 6000.0})[1] == [True]


def test_an_expected_reading_beyond_a_limit_raises_no_alarm() -> None:
    # 4.9 kW are a standard deviation of 3 % below the limit of 5 kW
    assert watched({"peak_power": 5050.0}, peak=4900.0)[1] == [False]
    # no alarm either where the members disagree
    assert watched({"size_error": 21.0}, size=10.0, spread=1.0)[1] == [False]


def test_repeated_surprises_raise_an_alarm_only_near_a_limit() -> None:
    near = {"peak_power": 5600.0, "mean_power": 4000.0}
    # ln(5600 / 5200) over 3.4 % is 2.2, of which 1.2 count
    watch, alarms = watched(*[near] * 6, peak=5200.0)
    assert alarms == [False] * 5 + [True]
    assert watch.said(0) == [
        "peak power 5.60 kW, where 5.03 to 5.38 was forecast; it has been above its forecast before"
    ]
    # no alarm for an equal surprise far from the limit or on the good side
    assert not any(watched(*[{"peak_power": 3200.0}] * 20, peak=2970.0)[1])
    assert not any(watched(*[{"peak_power": 5200.0}] * 20, peak=5600.0)[1])


def test_a_repeated_size_is_no_new_reading() -> None:
    watch, _ = watched({"size_error": 12.0})
    assert watch.seen.new[0].tolist() == [True, True, True, True]
    watch.update(observation(PLATES, **(USUAL | {"size_error": 12.0})), PowerLaw(1))
    assert watch.seen.new[0].tolist() == [True, True, False, False]


def test_low_readings_raise_doubt_but_no_alarm() -> None:
    assert not watched(*[{}] * 50)[0].doubt[0]
    # a meter that shows 20 % too little is on the good side of every limit
    watch, alarms = watched(*[{"peak_power": 3700.0, "mean_power": 3300.0}] * 4)
    assert watch.doubt[0] and not any(alarms)


def test_the_burn_ratio_is_given_per_watt() -> None:
    # Malkin's ratio compares two powers: members that take 4.5 kW are at 0.6 of the burning limit
    watch, _ = watched({"peak_power": 6000.0}, heat=0.6)
    assert watch.burn_per_watt[0] == pytest.approx(0.6 / 4500.0, rel=1e-6)


def test_a_constant_size_error_raises_doubt_even_once_it_is_forecast() -> None:
    watch, alarms = watched(*[{"size_error": 9.0}] * 20)
    # 4 um over hypot(0.7, 0.5) = 0.86 um
    assert watch.seen.forecast[0, 2] == pytest.approx(9.0, abs=0.5)
    assert watch.doubt[0] and not any(alarms)
    # the model includes wheels that leave twice the Ra
    assert not watched(*[{"roughness": 0.9 + 1e-3 * (k % 2)} for k in range(20)])[0].doubt[0]


def test_without_an_ensemble_the_power_law_forecasts() -> None:
    simulation: Any = shortened("power_limited", 2)
    simulation.compiled = False
    watch: Any = Watch(simulation, 1)
    law = PowerLaw(1)
    assert watch.belief is None
    watch.update(observation(watch.simulation), law)
    for power in (*[2000.0] * 30, 5200.0):
        law.learn(np.array([power]), np.array([100.0]), np.array([50.0]), np.ones(1, bool))
        watch.update(observation(watch.simulation, peak_power=power), law)
    assert np.exp(watch.seen.forecast[0, 0]) == pytest.approx(2000.0, rel=0.05)
    assert watch.alarm.tolist() == [True]


def test_the_policy_returns_in_steps_after_an_alarm_and_later_each_time() -> None:
    policy: Any = Guarded(Fixed(20_000.0, 1))
    policy.begin(PLATES, 1)
    alarm = iter([0, 1] + [0] * 13 + [1] + [0] * 30)

    def update(seen: Any, law: Any) -> None:
        policy.watch.alarm, policy.watch.holds = np.array([bool(next(alarm))]), np.array([True])

    policy.watch.update = update
    speeds, last = [], 6000.0
    for _ in range(26):
        decision = policy.act(observation(PLATES, last_speed=last, peak_power=4000.0, **GROUND), None)
        last = float(decision.speeds[0])
        speeds.append(last)
    assert speeds[0] == 20_000.0
    # four blocks of the rule, then up by a quarter from block to block
    assert max(speeds[1:5]) < 15_000.0
    for k in (*range(5, 10), 23, 24):
        assert speeds[k] == pytest.approx(min(1.25 * speeds[k - 1], 20_000.0), abs=1.0)
    # the second alarm, after block 14, lasts twice as long
    assert speeds[14] == 20_000.0
    assert max(speeds[15:23]) < speeds[23] < 20_000.0


GROUND = {"last_pick": 0.02, "last_width": 50.0, "pick": 0.02, "width": 50.0, "length": 300.0, "stock": 1.0}


def test_the_guard_is_far_cheaper_than_a_bad_plan_and_near_the_rule() -> None:
    task = load_task("power_limited")
    hard = BlockSimulation(replace(task, factors={**task.factors, "u_ch": 1.35, "kp": 1.35, "kc": 1.35, "pm": 1.35}))
    seeds, plan = episode_seeds("validation", 8), Fixed(8000.0, 1, 2)

    def cost(policy: Any, machine: BlockSimulation) -> float:
        run = roll_out(policy, machine, start_episodes(machine, seeds), PLATES)
        return float(cost_per_good_part(run.cost, run.good))

    assert cost(guarded(plan), hard) < 0.2 * cost(plan, hard)
    rule = named_policy("empirical_rule", PLATES)
    assert cost(guarded(plan), hard) < 1.5 * cost(rule, hard)


def test_on_the_model_the_guarded_policy_decides() -> None:
    seeds = episode_seeds("validation", 8)
    plan = run_seeds(Fixed(6000.0, 1, 1), PLATES, seeds)
    guarded_run = run_seeds(guarded(Fixed(6000.0, 1, 1)), PLATES, seeds)
    assert np.mean(plan.speeds == guarded_run.speeds) > 0.95


@pytest.mark.parametrize("env", ["reciprocation", "job_shop"])
def test_it_guards_in_every_form_of_environment(env: str) -> None:
    simulation = shortened(env, 2)
    run = run_seeds(guarded(named_policy("handbook", simulation)), simulation, range(2))
    assert run.finished.tolist() == [2.0, 2.0]


def test_a_prefix_of_the_name_guards_any_policy() -> None:
    simulation = find_problem("power_limited").simulation()
    assert named_policy("guarded:E6000D1", simulation).name == "guarded:E6000D1"
    agent = "grind_env/policies/shipped/plain_gru/power_limited.safetensors"
    assert named_policy(f"guarded:{agent}", simulation).name.startswith("guarded:")
    planner = named_policy("guarded:hindsight", simulation)
    assert planner.sees == "future"
    with pytest.raises(ConfigError, match="no policy 'nobody'"):
        named_policy("guarded:nobody", simulation)
