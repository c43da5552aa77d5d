import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.passive_env_checker import env_render_passive_checker

from grind_env.envs import task_env_factory
from grind_env.render import frames, terminal_view
from grind_env.render.picture_data import NoScreenError
from tests.envs.harness import every_id, native

ACTION = np.zeros(2, np.float32)


@pytest.mark.parametrize("env_id", every_id())
@pytest.mark.parametrize("mode", ["rgb_array", "ansi"])
@pytest.mark.filterwarnings("error")
def test_rendering_passes_the_checker_of_gymnasium(env_id: str, mode: str) -> None:
    env = gym.make(env_id, render_mode=mode)
    env.reset(seed=0)
    env_render_passive_checker(env.unwrapped)
    env.step(env.action_space.sample())
    env_render_passive_checker(env.unwrapped)


def test_the_picture_and_the_text_show_the_state_after_the_step() -> None:
    shown = {}
    for mode in ("rgb_array", "ansi"):
        env = task_env_factory.make("oracle6", render_mode=mode, show_block=True)
        env.reset(seed=0)
        first = env.render()
        *_, info = env.step(ACTION)
        shown[mode] = env.render()
        view = env.view()
        assert view.cost == info["block_cost"]
        assert info["block"] == view.text
        assert np.any(first != shown[mode])
        env.reset(seed=0)
        assert np.all(env.render() == first)
    assert np.array_equal(shown["rgb_array"], frames.render(view))
    assert shown["ansi"] == terminal_view.panel(view)


@pytest.mark.parametrize("env_id", ["grind/Job-v0", "grind/Reciprocation-v0"])
def test_a_view_sums_the_infos_of_the_steps(env_id: str) -> None:
    env = gym.make(env_id, render_mode="ansi", info="full", show_block=True)
    env.action_space.seed(1)
    env.reset(seed=2)
    infos, terminated = [], False
    while not terminated:
        _, _, terminated, _, info = env.step(env.action_space.sample())
        infos.append(info)
        view = env.unwrapped.view()
        assert view.text == info["block"]
        assert (view.number, view.ground[-1].speed) == (len(infos), info["E"])
        assert sum(block.executions for block in view.ground) == sum(each["D"] for each in infos)
    assert view.number == view.extent.blocks and view.finished_parts == view.extent.parts
    assert view.cost == pytest.approx(sum(info["block_cost"] for info in infos), rel=1e-9)
    assert view.good_parts == pytest.approx(sum(info["good_parts"] for info in infos), rel=1e-9)
    assert all(f"{line}" in env.render() for line in info["block"].split("\n"))


def test_rendering_before_the_first_reset_is_refused() -> None:
    with pytest.raises(ResetNeeded, match=r"call reset\(\) before render\(\)"):
        task_env_factory.make(render_mode="ansi").render()


def test_human_mode_shows_a_picture_of_every_step(monkeypatch: pytest.MonkeyPatch) -> None:
    pictures, closed = [], []

    class Screen:
        def show(self, picture: np.ndarray) -> None:
            pictures.append(picture)

        def close(self) -> None:
            closed.append(True)

    monkeypatch.setattr(frames, "open_window", lambda title: Screen())
    env = task_env_factory.make("oracle6", render_mode="human")
    env.reset(seed=0)
    env.step(ACTION)
    env.step(ACTION)
    assert env.render() is None
    assert len(pictures) == 4
    assert (pictures[0] != pictures[1]).any() and (pictures[2] == pictures[3]).all()
    env.close()
    env.close()
    assert closed == [True]


def test_human_mode_prints_text_without_a_screen(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def no_screen(title: str) -> None:
        raise NoScreenError("there is no screen")

    monkeypatch.setattr(frames, "open_window", no_screen)
    env = task_env_factory.make("oracle6", render_mode="human")
    env.reset(seed=0)
    capsys.readouterr()
    env.step(ACTION)
    assert capsys.readouterr().out == terminal_view.panel(env.view()) + "\n"
    env.close()


@pytest.mark.parametrize("env_id", every_id())
def test_a_vector_environment_renders_like_its_single_environments(env_id: str) -> None:
    vector = native(env_id, 2, render_mode="ansi")
    singles = [gym.make(env_id, render_mode="ansi") for _ in range(2)]
    vector.reset(seed=4)
    for i, env in enumerate(singles):
        env.reset(seed=4 + i)
    vector.action_space.seed(0)
    for _ in range(2):
        assert vector.render() == tuple(env.render() for env in singles)
        actions = vector.action_space.sample()
        vector.step(actions)
        for env, action in zip(singles, actions, strict=True):
            env.step(action)
    assert vector.render() == tuple(env.render() for env in singles)


def test_a_restarted_episode_shows_nothing_of_the_previous_one() -> None:
    env = native("grind/Oracle6-v0", 2, "NextStep", render_mode="ansi")
    env.reset(seed=0)
    for _ in range(6):
        env.step(np.zeros((2, 2)))
    assert all("block 6 of 6" in text for text in env.render())
    env.step(np.zeros((2, 2)))
    assert all("block 0 of 6" in text for text in env.render())
