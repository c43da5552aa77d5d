"""Contexts and splits of the user's job: options as for the other tasks, for the random factors of a job."""

import functools
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest

from grind_env.envs.distribution_splits import SPLITS
from grind_env.envs.env import GrindEnv
from grind_env.envs.ids import job
from grind_env.envs.job.job_noise_tape import WHEEL_SPREAD, unfixable_factors
from grind_env.envs.job.job_observation import job_task
from grind_env.envs.random_numbers import EPISODE
from grind_env.envs.reset_options import CONTEXT_FACTORS, ContextError, Given, read_options
from grind_env.kernel.random import philox
from grind_env.machine.job import Lots
from tests.envs.harness import JobTape, assert_same, job_drawn
from tests.envs.test_reset_options import DECILES

FIXABLE = ("kA", "pm", "wheel_kA", "ra_scale", "fc", "Gref", "hf", "noise")


@functools.cache
def example() -> GrindEnv:
    return job.make()


def given_of(options: dict[str, Any]) -> Given:
    return read_options(job_task("job", example().simulation.job, 1.0, ""), options, Given(), unfixable_factors(1.0))


def tape_of(options: dict[str, Any], seed: int, parts: int = 50, spread: float = 1.0) -> JobTape:
    return job_drawn(np.random.default_rng(seed), parts, spread, given_of(options))


def column(tape: JobTape, name: str) -> np.ndarray:
    return np.array([condition.factors[name] for condition in tape.conditions])


def episode(env: GrindEnv, seed: int, options: Any = None) -> list[Any]:
    """Return observations and rewards of an episode of the example."""
    steps = [env.reset(seed=seed, options=options)[0]]
    for D in (0.0, 1.0):
        steps.append(env.step(np.array([0.2, 2.0 * (D + 0.5) / 4.0 - 1.0], np.float32))[:2])
    return steps


@pytest.mark.parametrize("name", [*CONTEXT_FACTORS, "material", "sequence"])
def test_a_factor_either_changes_something_or_is_refused(name: str) -> None:
    env = job.make(observation="full")
    if name in FIXABLE:
        shown = [episode(env, 0, {"context": {"noise": 1.0, name: value}}) for value in (1.0, 1.5)]
        with pytest.raises(AssertionError):
            assert_same(*shown)
        return
    with pytest.raises(ContextError, match=f"say what is ground and with which wheel: {name} cannot be fixed"):
        env.reset(options={"context": {name: 1.0}})


def test_exact_gauges_have_no_noise_to_fix() -> None:
    with pytest.raises(ContextError, match="with spread=0 the gauges are exact: noise cannot be fixed, leave it out"):
        job.make(spread=0.0).reset(options={"context": {"noise": 1.0}})


def test_the_nominal_context_equals_a_job_without_spread() -> None:
    env, nominal = job.make(), job.make(spread=0.0)
    for seed in (0, 1):
        assert_same(episode(env, seed, {"context": "nominal"}), episode(nominal, seed))


def test_a_context_does_not_change_the_draws_of_other_factors() -> None:
    plain, fixed = tape_of({}, 3), tape_of({"context": {"kA": 2.0, "noise": 0.5, "fc": 1.1}}, 3)
    for name in ("pm", "hf", "Gref", "ra_scale"):
        np.testing.assert_array_equal(column(plain, name), column(fixed, name))
    assert (column(fixed, "fc") == 1.1).all() and len(set(column(plain, "kA"))) > 3
    # every lot has the factor 2, multiplied by the factor of the wheel
    np.testing.assert_allclose(column(fixed, "kA"), 2.0 * np.exp(0.20 * clipped_normal(3)), rtol=1e-9)
    np.testing.assert_array_equal(fixed.noise, 0.5 * plain.noise)
    assert fixed.new_lot == plain.new_lot and sum(plain.new_lot) > 3
    both = tape_of({"context": {"kA": 2.0, "pm": 1.0}}, 3)
    assert both.new_lot == (True, *[False] * 49)  # a lot without any difference is not new


def clipped_normal(seed: int) -> float:
    """Return the standard normal number of the wheel, clipped like all of them."""
    first, second = np.floor(np.random.default_rng(seed).random(2) * 2.0**32).astype(int).tolist()
    word = philox(first, second, 0, EPISODE, 0, 0)[0]
    return float(np.clip(NormalDist().inv_cdf((word + 0.5) / 2.0**32), -1.8, 1.8))


def test_a_context_does_not_change_the_random_numbers_of_a_later_episode() -> None:
    followers = []
    for options in ({}, {"context": "nominal"}, {"split": "interpolation"}):
        rng = np.random.default_rng(0)
        job_drawn(rng, 9, 1.0, given_of(options))
        followers.append(rng.random())
    assert len(set(followers)) == 1


@pytest.mark.parametrize("name", SPLITS)
def test_every_factor_of_an_episode_comes_from_the_ranges_of_its_split(name: str) -> None:
    # the roughness of every part scatters on top of that of the wheel, in every split
    lots, given = Lots(roughness=0.0), given_of({"split": name})
    tapes = [job_drawn(np.random.default_rng(seed), 50, 1.0, given, lots) for seed in range(300)]
    for factor, sigma in {**WHEEL_SPREAD, "pm": Lots().pressure}.items():
        if factor == "kA":
            continue  # the product of two factors
        reach = SPLITS[name].reach if factor == "pm" else 1.0
        z = np.log(np.array([column(tape, factor) for tape in tapes]).ravel()) / (reach * sigma)
        near = np.abs(z[:, None] - DECILES).min(axis=-1) < 1e-3
        assert set(np.digitize(z[~near], DECILES)) == set(SPLITS[name].ranges or range(10)), factor


def test_extrapolation_keeps_the_stocks_of_a_program_and_widens_noise_and_growth() -> None:
    # all spreads of the lots table are 0
    alike = Lots(growth=0.0, pressure=0.0, stock=0.0, roughness=0.0)
    plain, beyond = (
        [job_drawn(np.random.default_rng(seed), 9, 1.0, given_of({"split": name}), alike) for seed in range(20)]
        for name in ("all", "extrapolation")
    )
    for one, other in zip(plain, beyond, strict=True):
        assert [part.stock for part in one.conditions] == [part.stock for part in other.conditions]
        np.testing.assert_allclose(other.noise, 3.0 * one.noise)
    # 1.28 to 1.8 standard deviations of 0.20, times 1.5
    growth = np.abs(np.log([column(tape, "kA")[0] for tape in beyond])) / WHEEL_SPREAD["kA"]
    assert (growth > 1.5 * 1.28).all() and (growth < 1.5 * 1.801).all()
