"""Rendering of the single environments: each shows a view of its episode in the same three ways."""

from typing import Any, TypeVar

import gymnasium as gym

from grind_env.render import ansi, frames
from grind_env.render.view import EpisodePicture

RENDER_MODES = ("rgb_array", "human", "ansi")
METADATA: dict[str, Any] = {"render_modes": [*RENDER_MODES], "render_fps": frames.FPS}

Make = TypeVar("Make")


def renders(make: Make) -> Make:
    """Let a function that makes environments say how they render, as a class does: `gym.make` asks what it calls."""
    vars(make)["metadata"] = METADATA
    return make


class Showing:
    """Renders what `view()` gives; a mixin, to be listed before `gymnasium.Env` among the bases."""

    metadata = METADATA
    render_mode: str | None
    follower: frames.Follower | None = None

    def view(self) -> EpisodePicture:
        """What a picture shows now.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
        """
        raise NotImplementedError

    def render(self) -> Any:
        """What the last step has led to: a picture, uint8 of shape (540, 960, 3), or text; None for a human.

        Raises:
            gymnasium.error.ResetNeeded: before the first reset.
            RenderError: if what draws it is not installed, or the user has closed the window.
        """
        view = self.view()
        if self.render_mode is None:
            gym.logger.warn("render() shows nothing: make the env with render_mode='rgb_array', 'human' or 'ansi'")
            return None
        if self.render_mode == "ansi":
            return ansi.panel(view)
        if self.render_mode == "rgb_array":
            return frames.render(view)
        self.follower = self.follower or frames.Follower(view.title)
        self.follower.show(view)
        return None

    def close(self) -> None:
        """Close the window, if there is one."""
        if self.follower is not None:
            self.follower.close()
            self.follower = None

    def follow(self) -> None:
        """Show a human what a reset or a step has led to."""
        if self.render_mode == "human":
            self.render()
