"""Policies that use the model while an out-of-model machine grinds."""

import json
from pathlib import Path

import numpy as np
import pytest

from grind_env import evaluate
from grind_env.envs.episode_state import Episodes
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.machine.grind import grind_file
from grind_env.machine.loops.row_io import OWN_FROM
from grind_env.plants import find_plant
from grind_env.policies.choices import Decision
from grind_env.policies.episode_trace import follow
from grind_env.policies.evaluation import start_episodes
from grind_env.policies.nominal_model import model_of, on, parted
from grind_env.policies.problem_lookup import find_problem
from tests.command import Grind
from tests.envs.test_job_env import GROOVED, written

PLATES = find_problem("power_limited")
PLANT = "held-out:4"


class Looker:
    """Policy that sees the state and records all episodes it is given."""

    name, sees = "looker", "state"

    def begin(self, simulation: Simulation, episodes: int) -> None:
        self.simulation, self.shown = simulation, []

    def act(self, observation: np.ndarray, episodes: Episodes | None) -> Decision:
        assert episodes is not None
        self.shown.append(episodes)
        return np.full(len(observation), 8000.0), np.zeros(len(observation))


def test_the_plant_grinds_while_the_policy_uses_the_model() -> None:
    looker = Looker()
    found = evaluate(looker, "power_limited", episodes=2, plant="held-out")
    model = find_plant("model")
    assert (looker.simulation.process, looker.simulation.gauge.own) == (model.process, model.gauge.own)
    assert all(each.wheels.shape[1] == OWN_FROM + len(model.own) for each in looker.shown)
    assert (looker.shown[5].wheels[:, OWN_FROM:] > 0.0).all()  # the part is warm, also in the model
    alone = evaluate(Looker(), "power_limited", episodes=2)
    assert found.score is None and alone.plant == "" and "plant" not in alone.numbers()
    assert (found.evaluation.cost != alone.evaluation.cost).all()
    assert found.numbers()["plant"] == "held-out" and found.title.endswith(" in power_limited on held-out")
    simulation = on(PLATES, "held-out").simulation()
    names = [each.plant.text for each in _given(simulation, [2_000_000, 2_000_001])]
    one = evaluate(Looker(), "power_limited", episodes=2, plant=names[0])
    assert one.evaluation.cost[0] == found.evaluation.cost[0] != one.evaluation.cost[1]


def test_a_followed_policy_and_a_policy_beside_it_use_the_model() -> None:
    judged = evaluate(Looker(), "power_limited", episodes=2, plant=PLANT)
    looker, beside = Looker(), Looker()
    beside.name = "beside"
    found = follow(looker, on(PLATES, PLANT), beside=[beside], episodes=2)
    np.testing.assert_allclose(found.cost.sum(axis=1), judged.evaluation.cost)
    model = find_plant("model")
    for each in (looker, beside):
        assert (each.simulation.process, each.simulation.gauge.own) == (model.process, model.gauge.own)
        assert all(shown.wheels.shape[1] == OWN_FROM + len(model.own) for shown in each.shown)
    alone = follow(Looker(), PLATES, episodes=2)
    assert (found.belief.wear_flat[:, 1:] != alone.belief.wear_flat[:, 1:]).all()


def _given(simulation: Simulation, seeds: list[int]) -> list:
    from grind_env.envs.reset_options import Given, with_machines

    return list(with_machines(simulation, [Given()] * len(seeds), [np.random.default_rng(seed) for seed in seeds]))


def test_a_true_model_sees_the_whole_state_and_a_wrong_one_its_own_numbers() -> None:
    machine = on(PLATES, PLANT).simulation()
    episodes = start_episodes(machine, range(2))
    known, other = model_of(PLATES, PLANT), model_of(PLATES, "held-out:9")
    assert known.plants.text == PLANT
    mine, theirs = find_plant(PLANT), find_plant("held-out:9")
    show_known, show_other = (parted(Looker(), machine, each, episodes) for each in (known, other))
    episodes.wheels[:, OWN_FROM:] += 1.0  # the machine has changed since
    assert show_known(episodes).wheels.tobytes() == episodes.wheels.tobytes()
    expected = [own + 1.0 if own == mine.own[k] else own for k, own in enumerate(theirs.own)]
    assert show_other(episodes).wheels[0, OWN_FROM:].tolist() == expected
    assert 0 < sum(a != b for a, b in zip(mine.own, theirs.own, strict=True)) < len(mine.own)


def test_a_state_policy_is_rejected_for_a_program_without_a_script(tmp_path: Path) -> None:
    path = written(tmp_path, GROOVED)
    machine = on(find_problem(path), "soft:3").simulation()
    assert not machine.compiled
    with pytest.raises(GrindError, match="looker sees the state, but the control executes part step by step"):
        parted(Looker(), machine, model_of(find_problem(path)), machine.empty_episodes(0))


def test_evaluate_needs_a_seed_for_its_model_and_a_plant_beside_it() -> None:
    with pytest.raises(GrindError, match="model is 'held-out', but a policy holds one machine: give a seed"):
        evaluate("E7000D1", "power_limited", episodes=2, plant=PLANT, model="held-out")
    with pytest.raises(GrindError, match="model is 'meter:7', but what grinds is the model: give a plant, too"):
        evaluate("E7000D1", "power_limited", episodes=2, model="meter:7")


@pytest.mark.nightly
def test_commands_name_the_machine(tmp_path: Path, grind: Grind) -> None:
    numbers = json.loads(grind("evaluate", "--policy", "E7000D1", "--episodes", 2, "--plant", PLANT, "--json")[1])
    assert (numbers["plant"], numbers["model"]) == (PLANT, "model") and "score" not in numbers
    program, record = tmp_path / "played.nc", tmp_path / "record.csv"
    said = grind("play", "--policy", "E7000D1", "--plant", "held-out", "--output", program, "--seed", 3)[1]
    plant = grind_file(program).job.plant
    assert plant.startswith("held-out:") and f"seed 3, split all, on {plant}:" in said
    shown = json.loads(grind("run", program, "--json", "--record", record)[1])
    assert shown["plant"] == plant
    lines = record.read_text().splitlines()
    assert lines[0].endswith(",plant") and all(line.endswith(f",{plant}") for line in lines[1:])
    plain = json.loads(grind("run", program, "--json", "--plant", "model")[1])
    assert plain["plant"] == "model" and plain["cost"] != shown["cost"]
    assert f"played.nc, not calibrated, on {PLANT}\n" in grind("run", program, "--plant", PLANT)[1]


def test_commands_reject_an_unknown_plant(grind: Grind) -> None:
    for words in (("evaluate", "--episodes", 2), ("play",), ("run", "grind_env/examples/plate_g82.nc")):
        status, _, err = grind(*words, "--plant", "metre:7")
        assert status == 2 and "there is no machine 'metre:7' (did you mean meter?)" in err
