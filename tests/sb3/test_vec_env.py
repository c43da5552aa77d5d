import itertools

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import RecordEpisodeStatistics
from stable_baselines3 import A2C
from stable_baselines3.common.vec_env import DummyVecEnv, VecCheckNan, VecEnv, VecMonitor, VecNormalize

from grind_env.envs import task_env_factory
from grind_env.envs.vector_env import GrindVectorEnv
from grind_env.envs.wrappers import BeliefFilter, HistoryStack, VectorBeliefFilter, VectorHistoryStack
from grind_env.errors import GrindError
from grind_env.sb3.vec_env import SB3VecEnv
from tests.examples import few

FLAGSHIP = "grind/PowerLimited-v0"
IDS = sorted(each for each in gym.registry if each.startswith("grind/"))
WRAPPERS = {BeliefFilter: VectorBeliefFilter, HistoryStack: VectorHistoryStack}


def native(envs: int = 3, **arguments) -> GrindVectorEnv:
    return task_env_factory.make_vector(envs, autoreset_mode="SameStep", **arguments)


def singles(env_id: str, wrap=lambda env: env, **arguments) -> DummyVecEnv:
    return DummyVecEnv([lambda: wrap(gym.make(env_id, **arguments)) for _ in range(3)])


def assert_alike(adapter: SB3VecEnv, dummy: DummyVecEnv, steps: int) -> int:
    """Compare observations, rewards, ends and infos with their types; return the number of ended episodes."""
    for env in (adapter, dummy):
        env.seed(7)
    np.testing.assert_array_equal(adapter.reset(), dummy.reset(), strict=True)
    assert adapter.reset_infos == dummy.reset_infos
    rng, ends = np.random.default_rng(0), 0
    for _ in range(steps):
        actions = rng.uniform(-1, 1, (3, *adapter.action_space.shape)).astype(np.float32)
        *ours, infos = adapter.step(actions)
        *theirs, their_infos = dummy.step(actions)
        for mine, other in zip(ours, theirs, strict=True):
            np.testing.assert_array_equal(mine, other, strict=True)
        np.testing.assert_equal(infos, their_infos)
        for mine, other in zip(infos, their_infos, strict=True):
            assert {name: type(value) for name, value in mine.items()} == {n: type(v) for n, v in other.items()}
        ends += int(ours[-1].sum())
    return ends


def test_the_adapter_behaves_like_dummy_vec_env():
    assert assert_alike(SB3VecEnv(native(show_block=True)), singles(FLAGSHIP, show_block=True), 130) == 6


@pytest.mark.parametrize("env_id", IDS)
def test_every_id_gives_the_same_results_as_with_dummy_vec_env(env_id):
    short = {"max_episode_steps": 3}
    adapter = SB3VecEnv(gym.make_vec(env_id, num_envs=3, autoreset_mode="SameStep", **short))
    assert assert_alike(adapter, singles(env_id, **short, show_block=False), 7) >= 6


@pytest.mark.parametrize("wrap", WRAPPERS)
def test_the_adapter_takes_wrapped_environments(wrap):
    short = {"max_episode_steps": 5, "show_block": False}
    adapter, plain = SB3VecEnv(WRAPPERS[wrap](native(**short))), SB3VecEnv(native(**short))
    assert assert_alike(adapter, singles(FLAGSHIP, wrap, **short), 12) == 6
    for env in (adapter, plain):
        env.seed(3)
    shown, measured = adapter.reset(), plain.reset()
    entries = measured.shape[1]
    # the filter appends the belief, the last part of a stack is the observation and the action that led to it
    part = shown[:, :entries] if wrap is BeliefFilter else shown[:, -entries - 2 : -2]
    assert np.array_equal(part, measured)
    # attributes missing on the wrapper come from the environment
    assert adapter.get_attr("task") == plain.get_attr("task")
    named = len(adapter.env_method("observation_info")[0])
    assert named == (shown.shape[1] if wrap is BeliefFilter else entries)


@pytest.mark.parametrize("wrap", WRAPPERS.values())
def test_wrapped_environments_take_reset_options_for_each_environment(wrap):
    options = [{"context": {"kA": 5.0, "stock": 1.2}}, {}, {"split": "interpolation"}]
    env = SB3VecEnv(wrap(native()))
    env.seed(7)
    env.set_options(options)
    together = env.reset()
    for i, each in enumerate(options):
        alone = wrap(native(1))
        assert np.array_equal(alone.reset(seed=7 + i, options=each)[0][0], together[i])


@pytest.mark.parametrize("wrap", few([*WRAPPERS.values(), RecordEpisodeStatistics]))
def test_agents_train_on_wrapped_environments(wrap):
    env = VecMonitor(SB3VecEnv(wrap(native(max_episode_steps=4))))
    model = A2C("MlpPolicy", env, n_steps=8, device="cpu").learn(48)
    assert model.num_timesteps == 48
    assert [info["l"] for info in model.ep_info_buffer] == [4] * 12


def stepped(env: VecEnv, steps: int) -> list[dict]:
    env.seed(0)
    env.reset()
    for _ in range(steps):
        *_, infos = env.step(np.zeros((3, 2), np.float32))
    return infos


def test_vec_monitor_records_episodes_and_its_info_keywords():
    infos = stepped(VecMonitor(SB3VecEnv(native()), info_keywords=("block_cost", "E")), 60)
    assert [info["episode"]["l"] for info in infos] == [60] * 3
    assert [info["episode"]["block_cost"] for info in infos] == [info["block_cost"] for info in infos]


def test_episode_statistics_of_gymnasium_reach_the_infos():
    infos = stepped(SB3VecEnv(RecordEpisodeStatistics(native(max_episode_steps=4))), 4)
    monitored = stepped(VecMonitor(SB3VecEnv(native(max_episode_steps=4))), 4)
    assert [info["episode"]["l"] for info in infos] == [4] * 3
    returns = [info["episode"]["r"] for info in infos]
    assert returns == pytest.approx([info["episode"]["r"] for info in monitored], rel=1e-5)


class CountingResets(gym.Wrapper):
    """Wrapper that counts the resets in the info of a reset."""

    resets = 0

    def reset(self, **kwargs):
        self.resets += 1
        observation, info = super().reset(**kwargs)
        return observation, {**info, "resets": self.resets}


def test_reset_infos_belong_to_the_new_episode():
    def make():
        return CountingResets(gym.make("grind/Slot-v0", max_episode_steps=3, show_block=False))

    sync = gym.vector.SyncVectorEnv([make] * 3, autoreset_mode=AutoresetMode.SAME_STEP)
    adapter, dummy = SB3VecEnv(sync), DummyVecEnv([make] * 3)
    assert assert_alike(adapter, dummy, 7) == 6
    assert adapter.reset_infos == dummy.reset_infos == [{"resets": 3}] * 3


def test_wrappers_of_stable_baselines3_do_not_change_the_infos():
    plain = stepped(SB3VecEnv(native(max_episode_steps=4)), 4)
    wrapped = stepped(VecCheckNan(VecNormalize(SB3VecEnv(native(max_episode_steps=4)))), 4)
    for one, other in zip(plain, wrapped, strict=True):
        # only the second terminal observation is normalised
        assert not np.array_equal(one.pop("terminal_observation"), other.pop("terminal_observation"))
        assert one == other
        assert one["TimeLimit.truncated"] is True


def test_the_adapter_takes_options_as_dummy_vec_env_does():
    adapter, dummy = SB3VecEnv(native()), singles(FLAGSHIP)
    action, shown = np.zeros((3, 2), np.float32), []
    # an option holds until the next one replaces it
    for options in (
        [{"context": {"kA": 5.0, "stock": 1.2}}, {}, {"split": "interpolation"}],
        [{}, {"context": {"kA": 0.5}}, {}],
        {"context": "nominal"},
    ):
        for env in (adapter, dummy):
            env.seed(7)
            env.set_options(options)
            shown.append([env.reset(), *(env.step(action)[0] for _ in range(2))])
    assert np.array_equal(shown[0::2], shown[1::2])
    assert not any(np.array_equal(before, after) for before, after in itertools.pairwise(shown[0::2]))


def test_the_adapter_never_overwrites_returned_arrays():
    env = SB3VecEnv(native())
    observations = env.reset()
    kept = observations.copy()
    _, rewards, _, _ = env.step(np.zeros((3, 2), np.float32))
    first = rewards.copy()
    env.step(np.ones((3, 2), np.float32))
    assert np.array_equal(observations, kept)
    assert np.array_equal(rewards, first)


def test_the_adapter_renders_the_same_pictures_as_dummy_vec_env():
    adapter, dummy = SB3VecEnv(native(render_mode="rgb_array")), singles(FLAGSHIP, render_mode="rgb_array")
    for env in (adapter, dummy):
        stepped(env, 2)
    assert adapter.metadata["render_fps"] == dummy.metadata["render_fps"]
    np.testing.assert_array_equal(adapter.get_images(), dummy.get_images())
    np.testing.assert_array_equal(adapter.render(), dummy.render())
    assert SB3VecEnv(native(render_mode="ansi")).get_images() == [None] * 3


def test_the_adapter_refuses_other_autoreset_modes():
    for wrap in (lambda env: env, *WRAPPERS.values()):
        with pytest.raises(GrindError, match=r"has AutoresetMode\.NEXT_STEP, but .* needs autoreset_mode='SameStep'"):
            SB3VecEnv(wrap(task_env_factory.make_vector(2)))
    silent = native()
    silent.metadata = {}
    with pytest.raises(GrindError, match="has no autoreset mode, but"):
        SB3VecEnv(silent)
