"""Learning adapters of the track: a fit to a log finds how the machine differs from the model."""

import numpy as np
import pytest

from agents.track.model_fit import CONSTANTS, changed, fitted, least_squares, residuals
from grind_env.envs.simulation import Simulation
from grind_env.policies.evaluation import start_episodes, steps
from grind_env.policies.nominal_model import model_of
from grind_env.policies.policy_lookup import named_policy
from grind_env.policies.problem_lookup import find_problem
from grind_env.policies.track import TrackShift, books
from grind_env.process.process_interface import PROCESS
from grind_env.process.stroke_types import StrokeParameters

PLATES = find_problem("power_limited")
ROUGH = [each.symbols for each in CONSTANTS].index(("RaRef",))


def ground(machine: Simulation, text: str, seeds: range) -> list[TrackShift]:
    """Return shifts of a plan on a simulated machine, one for each seed."""
    policy = named_policy(text, machine)
    all_of = list(steps(policy, machine, episodes := start_episodes(machine, seeds)))
    seen = np.stack([*(each.observation for each in all_of), machine.observe(episodes)], axis=1)
    E, D = (np.stack([each.choice[k] for each in all_of], axis=1) for k in range(2))
    found = [
        books(np.array([each.outcomes[i] for each in all_of]), np.random.default_rng(i)) for i in range(len(seeds))
    ]
    return [
        TrackShift(observations=seen[i], speeds=E[i], executions=D[i], cost=cost, bad=bad)
        for i, (bad, cost) in enumerate(found)
    ]


def test_least_squares_solve_a_linear_problem() -> None:
    rng = np.random.default_rng(1)
    slopes, aim = rng.normal(size=(30, 3)), rng.normal(size=30)
    expected = np.linalg.solve(slopes.T @ slopes + np.eye(3), slopes.T @ aim)
    found = least_squares(lambda z: slopes @ z - aim, np.array([0.5, 0.0, -0.5]))
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_a_changed_model_differs_in_the_changed_constants_only() -> None:
    model = model_of(PLATES)
    z = np.zeros(len(CONSTANTS))
    z[ROUGH], z[-1] = 2.0, 1.0
    other = changed(model, z)
    before, after = (StrokeParameters(*each.branches.base[0]) for each in (model, other))
    assert after.RaRef == pytest.approx(np.exp(0.3) * before.RaRef) and after._replace(RaRef=before.RaRef) == before
    own = other.start([np.random.default_rng(0)]).extra_state(0)
    heat, exponents = own[: len(PROCESS.own._fields)], own[len(PROCESS.own._fields) :]
    assert not any(heat) and exponents == (0.0, 0.0, 0.1)


@pytest.mark.nightly
def test_a_fit_to_a_log_finds_the_changed_constant() -> None:
    model, truth = model_of(PLATES), np.zeros(len(CONSTANTS))
    truth[ROUGH] = 2.0
    shifts = ground(changed(model, truth), "E6000D1", range(20))
    z = fitted(model, shifts, np.zeros(len(CONSTANTS)))
    assert z[ROUGH] == pytest.approx(2.0, abs=0.5) and np.abs(np.delete(z, ROUGH)).max() < 1.0
    before, best, after = (np.square(residuals(changed(model, each), shifts)).sum() for each in (0.0 * z, truth, z))
    assert after < best < 0.97 * before
