"""A window that shows pictures on the screen, made with tkinter."""

import time
import tkinter
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageTk

from grind_env.render.picture_data import NoScreenError, RenderError


class Window:
    """A window on the screen that shows at most `fps` pictures a second; `NoScreenError` without a screen."""

    def __init__(self, title: str, fps: float) -> None:
        try:
            self.root = tkinter.Tk()
        except tkinter.TclError as error:
            raise NoScreenError(f'there is no screen ({error}): use render_mode="rgb_array" or "ansi"') from None
        self.root.title(title)
        self.root.resizable(False, False)
        self.label = tkinter.Label(self.root, borderwidth=0)
        self.label.pack()
        self.pause = 1.0 / fps
        self.due = time.monotonic()
        self.shown: ImageTk.PhotoImage | None = None

    def show(self, frame: NDArray[np.uint8]) -> None:
        """Show a picture, shape (height, width, 3), once the last one has been shown long enough."""
        time.sleep(max(self.due - time.monotonic(), 0.0))
        self.due = time.monotonic() + self.pause
        try:
            # tkinter keeps no reference to the picture
            self.shown = ImageTk.PhotoImage(Image.fromarray(frame), master=self.root)
            self.label.configure(image=self.shown)
            self.root.update()
        except tkinter.TclError:
            raise RenderError("the window has been closed: make the environment anew to go on watching") from None

    def close(self) -> None:
        """Close the window if it is open."""
        self.shown = None
        with suppress(tkinter.TclError):  # the user has closed it
            self.root.destroy()
