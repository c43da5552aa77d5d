"""`grind train` makes an agent for the user's program; `grind advise` and `grind evaluate` take its file."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
import pytest
from safetensors.numpy import load_file

import grind_env
from grind_env.envs.job.loading import load_simulation
from grind_env.policies.evaluation import Evaluation
from grind_env.policies.problem_lookup import Problem, find_problem
from grind_env.policies.scoring import Judgement
from grind_env.training import gru_ppo
from grind_env.training.baselines import Programmed, fixed_plans
from grind_env.training.checkpoint import Checkpoint
from grind_env.training.gru_ppo import Settings, train
from grind_env.training.train_command import _problem, _verdict
from tests.command import Grind

EXAMPLES = Path(grind_env.__file__).parent / "examples"
QUICK = ("--steps", 10_000, "--episodes", 2)


@pytest.fixture
def part(tmp_path: Path) -> Path:
    """Return a program with its job."""
    for suffix in (".nc", ".toml"):
        (tmp_path / f"part{suffix}").write_bytes((EXAMPLES / f"plate_g82{suffix}").read_bytes())
    return tmp_path / "part.nc"


def test_grind_train_writes_an_agent_for_advise_and_evaluate(grind: Grind, part: Path, tmp_path: Path):
    status, said, told = grind("train", part, "--parts", 3, *QUICK)
    agent = part.with_suffix(".safetensors")
    assert (status, told) == (3, "")
    first, *judged, last, following = said.splitlines()
    assert re.fullmatch(rf"{agent}: not recommended: a good part costs .+ on machines of held-out-laws", first)
    assert re.fullmatch(rf"{agent}: trained in \d+ CPU-seconds", last)
    assert following == f"next: grind advise {part}, with the same --job, --parts and --set"
    rivals = ["adviser", "fixed plan: [0-9.]+ times E, a dress every (part|[24] parts)", "the program as it is"]
    for line, basis, name in zip(judged[::3], judged[2::3], ["ppo_gru", *rivals], strict=True):
        assert re.match(rf"{name} in part_x3 on held-out-laws", line) and "; sees measurements" in basis
    # `grind evaluate` prints the same lines about a policy
    words = ("--program", part, "--parts", 3, "--plant", "held-out-laws", "--seeds", "validation", "--episodes", 2)
    assert grind("evaluate", *words, "--policy", agent)[1].splitlines() == judged[:3]
    readings = tmp_path / "readings.csv"
    readings.write_text("mean_power\n2600\n")
    advised = grind("advise", part, "--parts", 3, "--policy", agent, "--measurements", readings)
    assert advised[0] == 0 and re.search(r"\bE\d{4,5}\b", advised[1])
    # an agent for three parts is refused for thirty, and the error says what to do
    said = "number of parts is 30, but was 3: train another agent with `grind train`, or accept"
    assert said in grind("advise", part, "--policy", agent)[2]


def test_train_and_advise_take_program_variables_from_set(grind: Grind, part: Path, tmp_path: Path):
    part.write_text(re.sub(r"E\d+\.?", "E#101", part.read_text(), count=1))
    # an unused variable gives a warning of one line
    sentence = "#500 was given a value at the start, but nothing has read it; leave it out, or mend its number"
    first = ("--set", "#101=15000", "--set", "#500=1", "--parts", 2)
    assert grind("train", part, *first, *QUICK)[::2] == (3, f"grind: warning: {sentence}\n")
    readings = tmp_path / "readings.csv"
    readings.write_text("mean_power\n2600\n")
    words = ("--policy", part.with_suffix(".safetensors"), "--measurements", readings)
    status, _, told = grind("advise", part, *first, *words)
    assert status == 0 and told.splitlines()[0] == sentence
    # a missing variable is an error, and so is --set for a task
    assert grind("train", part, "--parts", 2, *QUICK)[0] == 2
    assert "grind: --set is of a part program" in grind("train", "oracle6", "--set", "#101=1", *QUICK)[2]


def test_the_default_number_of_parts_is_30(part: Path):
    simulation: Any = _problem(str(part), None, None, None).simulation()
    assert len({block.part for block in simulation.blocks}) == 30


@pytest.mark.nightly
def test_the_agent_of_a_task_goes_to_the_current_folder(grind: Grind, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    status, said, _ = grind("train", "oracle6", "--plant", "model", *QUICK)
    assert status == 3 and "trained on the model" in said
    assert "\nempirical_rule in oracle6 on" in said and "\nfixed plan: E" in said and "the program" not in said
    # an old agent is replaced, any other file is not
    assert grind("train", "oracle6", *QUICK)[0] == 3
    (tmp_path / "oracle6.safetensors").write_text("mine")
    status, said, told = grind("train", "oracle6", *QUICK)
    assert (status, said) == (2, "") and "would be lost" in told
    assert (tmp_path / "oracle6.safetensors").read_text() == "mine"


@pytest.mark.nightly
def test_training_on_a_program_without_a_script_warns_that_it_is_slow(
    grind: Grind, part: Path, monkeypatch: pytest.MonkeyPatch
):
    part.write_text(part.read_text().replace("S1910 M03", "G96 S1800 M03"))
    few = {"steps": 8, "envs": 2, "rollout": 4, "minibatches": 1}
    monkeypatch.setattr(gru_ppo, "train", lambda problem, settings, *given: train(problem, replace(settings, **few), 0))
    status, said, told = grind("train", part, "--parts", 1, *QUICK)
    assert status == 3 and "\nadviser in" in said and "the program as it is" in said
    assert told.startswith("the control executes part step by step: 10,000 blocks may take hours; fewer --steps")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--memory", "all"), "--memory is 'all', but must be one of none, stack, gru, belief"),
        (("--max-scrap", "1"), "--max-scrap is 1, but must be a share between 0 and 1"),
        (("--seed", "399"), "--seed is 399, but must be at most 398"),
        (("--parts", "2"), "'oracle6' is no part program: leave out its job and its parts"),
        (("--plant", "metre"), "there is no machine 'metre' (did you mean meter?)"),
        (
            ("--plant", "held-out"),
            "--plant is 'held-out', but these machines judge agents: train on training, public, laws or model",
        ),
        (
            ("--plant", "held-out-laws"),
            "--plant is 'held-out-laws', but these machines judge agents: train on training, public, laws or model",
        ),
        (("--episodes", "600000"), "600000 episodes are asked for, but there are 1 to 500000 validation seeds"),
    ],
)
def test_bad_options_are_refused_before_any_work(grind: Grind, tmp_path: Path, words: tuple[str, ...], said: str):
    status, out, told = grind("train", "oracle6", *words, "-o", tmp_path / "agent.safetensors")
    assert (status, out) == (2, "") and told.startswith(f"grind: {said}") and told.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_an_agent_without_its_suffix_is_refused_before_the_training(grind: Grind, tmp_path: Path):
    status, out, told = grind("train", "oracle6", "-o", tmp_path / "agent")
    assert (status, out) == (2, "") and told.endswith("but agents are .safetensors files: name agent.safetensors\n")


def judged(costs: list[float], policy: str = "other") -> Judgement:
    """Return the judgement of a run with these costs in $ and one good part an episode."""
    cost = np.array(costs)
    run = Evaluation(cost, np.ones_like(cost), np.ones_like(cost), np.ones((len(cost), 1)), np.ones((len(cost), 1)))
    return Judgement(policy, "measurements", "part", "validation", "all", run, None, False, "laws")


def test_an_agent_is_recommended_only_if_significantly_cheaper_than_its_rivals():
    hard, easy = [8.0, 1.0] * 20, [4.0, 0.5] * 20
    less = "recommended: a good part costs 50 % less than with other (95 % CI 50 to 50) on machines of laws"
    assert _verdict(judged(easy), judged(hard)) == (True, less)
    assert _verdict(judged(easy), judged(hard), judged(easy, "plan")) == (True, less)
    told = "not recommended: a good part costs {} $ with {}, {} $ with the agent, on machines of laws"
    cheap = judged([2.0, 0.25] * 20, "plan")
    assert _verdict(judged(easy), judged(hard), cheap) == (False, told.format("1.12", "plan", "2.25"))
    assert _verdict(judged(hard), judged(hard)) == (False, told.format("4.50", "other", "4.50"))
    assert not _verdict(judged([20.0, *easy[1:-1], 150.0]), judged(hard))[0]
    assert "(may be chance)" in _verdict(judged([80.0, *easy[1:]]), judged(hard))[1]
    # without a good part the cost per good part is undefined
    spoilt = judged(easy)
    spoilt.evaluation.good[:] = 0.0
    none = "not recommended: a good part costs 4.50 $ with other, the agent makes none, on machines of laws"
    assert _verdict(spoilt, judged(hard)) == (False, none)
    assert _verdict(spoilt, spoilt)[1].startswith("not recommended: no policy makes a good part: check program and job")
    recommended, said = _verdict(judged(easy), spoilt)
    assert recommended and "100 % less" in said


def test_a_fixed_plan_scales_the_speeds_and_spaces_the_dresses_of_a_program():
    simulation = load_simulation(str(EXAMPLES / "plate_g82.nc"), None, 4, 1.0, "measured")
    said = np.array([(block.plan.feed, float(block.plan.dresses)) for block in simulation.blocks])
    plans = Programmed(), Programmed(0.8, 2)
    for plan in plans:
        plan.begin(simulation, 1)
    observation = np.zeros((1, 1), np.float32)
    made = np.array([[np.concatenate(plan.act(observation, None)) for _ in said] for plan in plans])
    assert np.array_equal(made[0], said)
    assert np.allclose(made[1][:, 0], 0.8 * said[:, 0])
    dressed = [block.part for block, executions in zip(simulation.blocks, made[1][:, 1], strict=True) if executions]
    assert dressed == [0, 2]
    for each in (simulation, find_problem("rush").simulation()):
        assert len({plan.name for plan in fixed_plans(each)}) == 15


@pytest.mark.nightly
def test_the_same_command_resumes_a_stopped_training(
    grind: Grind, part: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def stop(steps: int) -> None:
        if steps:
            raise KeyboardInterrupt

    def stopped(problem: Problem, settings: Settings, seed: int, _: object, checkpoint: Checkpoint) -> object:
        return train(problem, settings, seed, stop, checkpoint)

    monkeypatch.setattr(platformdirs, "user_cache_path", lambda name: tmp_path)
    words = ("train", part, "--parts", 2, "--steps", 16_000, "--episodes", 2, "--output")
    whole, resumed, other = (tmp_path / f"{name}.safetensors" for name in ("whole", "resumed", "other"))
    assert grind(*words, whole)[::2] == (3, "")
    with monkeypatch.context() as patch:
        patch.setattr(gru_ppo, "train", stopped)
        assert grind(*words, resumed)[0] not in (0, 3)
    # another seed or another machine starts a new training
    assert grind(*words, other, "--seed", 1)[::2] == (3, "")
    job = part.with_suffix(".toml")
    told = job.read_text()
    job.write_text(told + "\n[setup.machine_overrides]\npower_limit = 5000\n")
    assert job.read_text() != told and grind(*words, other)[::2] == (3, "")
    job.write_text(told)
    assert grind(*words, resumed)[::2] == (3, f"{resumed}: resuming the interrupted training\n")
    for one, again in zip(load_file(whole).items(), load_file(resumed).items(), strict=True):
        assert (one[0], one[1].tobytes()) == (again[0], again[1].tobytes())
    assert not list((tmp_path / "trainings").iterdir())
