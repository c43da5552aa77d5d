"""The film recorders of Gymnasium and Stable-Baselines3 work; `make films` runs this where moviepy is installed."""

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers import RecordVideo
from gymnasium.wrappers.vector import RecordVideo as VectorVideo
from stable_baselines3.common.vec_env import VecVideoRecorder

from grind_env.sb3 import SB3VecEnv
from tests.envs.harness import native

moviepy = pytest.importorskip("moviepy", reason="moviepy needs Pillow < 12; run `make films`")


def pictures(path: Path) -> list[Any]:
    """Return the frames of a film."""
    with moviepy.VideoFileClip(str(path)) as film:
        return list(film.iter_frames())


def mean_difference(a: Any, b: Any) -> float:
    """Return the mean difference of two pictures in grey levels; film compression causes some."""
    return float(np.abs(np.asarray(a, float) - np.asarray(b, float)).mean())


#: one environment for each kind of picture
FILMED = [f"grind/{name}-v0" for name in ("Oracle6", "Job", "Reciprocation", "WidePlates")]


@pytest.mark.parametrize("env_id", FILMED)
def test_a_film_has_a_picture_of_every_state(env_id: str, tmp_path: Path) -> None:
    env, shown, over = gym.make(env_id, render_mode="rgb_array"), 1, False
    env = RecordVideo(env, str(tmp_path / "film"), lambda number: True)
    env.action_space.seed(0)
    env.reset(seed=3)
    while not over and shown < 4:
        shown, over = shown + 1, any(env.step(env.action_space.sample())[2:4])
    last = env.unwrapped.render()
    env.close()
    (path,) = (tmp_path / "film").glob("*.mp4")
    frames = pictures(path)
    assert len(frames) == shown
    assert frames[0].shape == last.shape == (540, 960, 3)
    assert mean_difference(frames[-1], last) < min(3.0, mean_difference(frames[0], last))


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.DISABLED])
@pytest.mark.parametrize("env_id", ["grind/Oracle6-v0", "grind/Job-v0"])
def test_every_picture_of_a_vector_film_shows_all_machines(env_id: str, mode: AutoresetMode, tmp_path: Path) -> None:
    steps = 2
    env = VectorVideo(native(env_id, 2, mode, render_mode="rgb_array"), str(tmp_path / "film"), video_length=steps + 1)
    env.action_space.seed(0)
    env.reset(seed=3)
    plan = [env.action_space.sample() for _ in range(steps)]
    for action in plan:
        env.step(action)
    shown = env.unwrapped.render()
    env.close()
    (path,) = (tmp_path / "film").glob("*.mp4")
    frames = pictures(path)
    assert len(frames) == steps + 1
    rows, columns = frames[0].shape[0] // 540, frames[0].shape[1] // 960
    assert rows * columns == 2
    assert mean_difference(frames[-1], np.concatenate(shown, axis=0 if rows == 2 else 1)) < 3.0


def test_a_film_of_stable_baselines3_has_a_picture_of_every_state(tmp_path: Path) -> None:
    steps = 3
    envs = SB3VecEnv(native("grind/Oracle6-v0", 2, AutoresetMode.SAME_STEP, render_mode="rgb_array"))
    recorder = VecVideoRecorder(envs, str(tmp_path), lambda step: step == 0, video_length=steps)
    recorder.reset()
    for _ in range(steps):
        recorder.step(np.zeros((2, 2), np.float32))
    last = recorder.render()
    recorder.close()
    (path,) = tmp_path.glob("*.mp4")
    frames = pictures(path)
    assert len(frames) >= steps
    assert frames[0].shape == last.shape
    assert mean_difference(frames[-1], last) < mean_difference(frames[0], last)
