import re
from pathlib import Path

import pytest

from agents.commands.dataset import dataset
from agents.offline.dataset import PLACE, recorded
from agents.offline.qualities import EPISODES, QUALITIES, content_hash, policy_of, published, record
from grind_env.errors import GrindError
from grind_env.policies.evaluation import episode_seeds, run_seeds
from grind_env.policies.problem import find_problem

ORACLE, PLATES = find_problem("oracle6"), find_problem("power_limited")


@pytest.mark.bits
def test_the_published_hashes_are_those_of_the_data() -> None:
    assert record("oracle6") == published()["oracle6"]
    assert {"power_limited", "oracle6"} <= set(published())
    assert all(list(hashes) == list(QUALITIES) for hashes in published().values())


def test_a_hash_is_of_every_number_of_an_episode() -> None:
    data = recorded(policy_of("rule", PLATES.simulation()), PLATES, episode_seeds("training", 2))
    assert [len(each) for each in data[0]] == [61, 60, 60, 60]
    before = content_hash(data)
    for k, numbers in enumerate(data[-1]):
        other = numbers.copy()
        other.flat[-1] += 1.0
        assert content_hash([data[0], (*data[-1][:k], other, *data[-1][k + 1 :])]) != before


def test_each_quality_is_better_than_the_one_before() -> None:
    simulation, seeds = PLATES.simulation(), episode_seeds("evaluation", 32)
    novice, rule, planner = (run_seeds(policy_of(each, simulation), simulation, seeds) for each in QUALITIES)
    assert planner.cost.mean() < 0.8 * rule.cost.mean() < 0.1 * novice.cost.mean()


def test_a_quality_is_refused_in_a_sentence() -> None:
    with pytest.raises(GrindError, match="there is no quality 'expert': choose from novice, rule, planner"):
        policy_of("expert", ORACLE.simulation())
    with pytest.raises(GrindError, match="policy is 'handbook', and the quality is 'rule': give one of both"):
        dataset(task="oracle6", policy="handbook", quality="rule")


def test_the_command_says_whether_a_dataset_is_the_published_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv(PLACE, str(tmp_path))
    dataset(task="oracle6", quality="novice")
    out = capsys.readouterr().out
    assert f"\nsha256 {published()['oracle6']['novice']}, as published\n" in out and f"{EPISODES} episodes" in out
    dataset(task="oracle6", quality="novice", episodes=3, fresh=True)
    assert re.search(r"\nsha256 [0-9a-f]{64}\n", capsys.readouterr().out)
