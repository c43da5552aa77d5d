import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.passive_env_checker import env_render_passive_checker

from grind_env.envs.env import GrindEnv
from grind_env.envs.view import view_of
from grind_env.render import ansi, frames
from grind_env.render.view import NoScreenError
from tests.envs.harness import IDS

ACTION = np.zeros(2, np.float32)


@pytest.mark.parametrize("env_id", IDS)
@pytest.mark.parametrize("mode", ["rgb_array", "ansi"])
@pytest.mark.filterwarnings("error")
def test_gymnasium_finds_nothing_wrong_with_rendering(env_id: str, mode: str) -> None:
    env = gym.make(env_id, render_mode=mode)
    env.reset(seed=0)
    env_render_passive_checker(env.unwrapped)
    env.step(ACTION)
    env_render_passive_checker(env.unwrapped)


def test_the_picture_and_the_text_show_the_state_after_the_step() -> None:
    shown = {}
    for mode in ("rgb_array", "ansi"):
        env = GrindEnv("oracle6", render_mode=mode)
        env.reset(seed=0)
        first = env.render()
        *_, info = env.step(ACTION)
        shown[mode] = env.render()
        view = view_of(env.task, env.episodes, 0, env.blocks, env.outcomes)
        assert view.cost == info["block_cost"]
        assert info["block"] == view.text
        assert np.any(first != shown[mode])
        env.reset(seed=0)
        assert np.all(env.render() == first)
    assert np.array_equal(shown["rgb_array"], frames.render(view))
    assert shown["ansi"] == ansi.panel(view)


def test_there_is_nothing_to_show_before_the_first_reset() -> None:
    with pytest.raises(ResetNeeded, match=r"call reset\(\) before render\(\)"):
        GrindEnv(render_mode="ansi").render()


def test_a_human_follows_every_step(monkeypatch: pytest.MonkeyPatch) -> None:
    pictures, closed = [], []

    class Screen:
        def show(self, picture: np.ndarray) -> None:
            pictures.append(picture)

        def close(self) -> None:
            closed.append(True)

    monkeypatch.setattr(frames, "open_window", lambda title: Screen())
    env = GrindEnv("oracle6", render_mode="human")
    env.reset(seed=0)
    env.step(ACTION)
    env.step(ACTION)
    assert env.render() is None
    assert len(pictures) == 4
    assert (pictures[0] != pictures[1]).any() and (pictures[2] == pictures[3]).all()
    env.close()
    env.close()
    assert closed == [True]


def test_without_a_screen_a_human_reads_text(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def no_screen(title: str) -> None:
        raise NoScreenError("there is no screen")

    monkeypatch.setattr(frames, "open_window", no_screen)
    env = GrindEnv("oracle6", render_mode="human")
    env.reset(seed=0)
    capsys.readouterr()
    env.step(ACTION)
    assert env.episodes is not None
    assert capsys.readouterr().out == ansi.panel(view_of(env.task, env.episodes, 0, env.blocks, env.outcomes)) + "\n"
    env.close()
