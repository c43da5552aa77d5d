"""Drawing of a view as a picture, and its display on the screen.

This module is light to import; the drawing library is loaded with the first picture.
"""

from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from grind_env.optional_libraries import needing
from grind_env.render.picture_data import EpisodePicture, NoScreenError, RenderError
from grind_env.render.terminal_view import panel

if TYPE_CHECKING:
    from grind_env.render.window import Window

WIDE = (960, 540)  #: width and height of a picture with the charts beside the machine, px
#: width and height of a picture with the charts below the machine, px; two such pictures fit side by side
TALL = (480, 640)

FPS = 10  #: pictures a second, one for each block, at which an episode can be followed by eye


def render(view: EpisodePicture, size: tuple[int, int] = WIDE) -> NDArray[np.uint8]:
    """Return the picture of a view, shape (height, width, 3); the size is `WIDE` or `TALL`.

    Raises:
        RenderError: for another size.
        MissingExtra: Pillow is not installed.
    """
    if size not in (WIDE, TALL):
        raise RenderError(f"the size of a picture is {size!r}, but must be {WIDE} or {TALL}")
    with needing("render", "pictures need"):
        from grind_env.render.layout import draw_tall, draw_wide
    return (draw_wide if size == WIDE else draw_tall)(view, *size).pixels()


def open_window(title: str) -> "Window":
    """Return a window that shows `FPS` pictures a second.

    Raises:
        RenderError: if Pillow or tkinter is not installed, or there is no screen.
    """
    try:
        with needing("render", "pictures need"):
            from grind_env.render.window import Window
    except ModuleNotFoundError as error:
        if error.name not in ("tkinter", "_tkinter"):
            raise
        raise RenderError(
            'this Python has no tkinter: install it (python3-tk), or use render_mode="rgb_array"'
        ) from None
    return Window(title, FPS)


class Follower:
    """Display of every state of an episode: in a window, or without a screen as text in the terminal.

    Raises:
        RenderError: if Pillow or tkinter is not installed.
    """

    def __init__(self, title: str) -> None:
        self.window: Window | None = None
        with suppress(NoScreenError):
            self.window = open_window(title)

    def show(self, view: EpisodePicture) -> None:
        """Show a state.

        Raises:
            RenderError: if the user has closed the window.
        """
        if self.window is None:
            print(panel(view))
        else:
            self.window.show(render(view))

    def close(self) -> None:
        """Close the window, if there is one."""
        if self.window is not None:
            self.window.close()
