"""The window without a screen: fake tkinter objects record the calls."""

import tkinter
from typing import Any

import numpy as np
import pytest
from PIL import Image, ImageTk

from grind_env.render.frames import render
from grind_env.render.picture_data import RenderError
from grind_env.render.window import Window
from tests.render.harness import VIEW


class Screen:
    """Fake of root window, label and picture in one."""

    def __init__(self) -> None:
        self.pictures: list[Image.Image] = []
        self.updates = 0
        self.open = True

    def update(self) -> None:
        if not self.open:
            raise tkinter.TclError("application has been destroyed")
        self.updates += 1

    def destroy(self) -> None:
        self.update()
        self.open = False

    def photo(self, picture: Image.Image, master: Any) -> str:
        assert master is self
        self.pictures.append(picture)
        return f"picture {len(self.pictures)}"

    def __getattr__(self, name: str) -> Any:
        return lambda *arguments, **options: None


@pytest.fixture
def screen(monkeypatch: pytest.MonkeyPatch) -> Screen:
    screen = Screen()
    monkeypatch.setattr(tkinter, "Tk", lambda: screen)
    monkeypatch.setattr(tkinter, "Label", lambda root, borderwidth: screen)
    monkeypatch.setattr(ImageTk, "PhotoImage", screen.photo)
    return screen


def test_the_window_shows_the_picture(screen: Screen) -> None:
    window = Window("grind", 1000.0)
    frame = render(VIEW)
    window.show(frame)
    assert screen.updates == 1
    assert np.array_equal(np.array(screen.pictures[0]), frame)


def test_a_picture_stays_for_its_frame_time(screen: Screen, monkeypatch: pytest.MonkeyPatch) -> None:
    clock, slept = [0.0], []

    def sleep(seconds: float) -> None:
        slept.append(seconds)
        clock[0] += seconds

    monkeypatch.setattr("grind_env.render.window.time.monotonic", lambda: clock[0])
    monkeypatch.setattr("grind_env.render.window.time.sleep", sleep)
    window = Window("grind", 10.0)
    window.show(render(VIEW))
    clock[0] += 0.04
    window.show(render(VIEW))
    clock[0] += 5.0
    window.show(render(VIEW))
    assert slept == pytest.approx([0.0, 0.06, 0.0])


def test_a_window_closed_by_the_user_raises_an_error_and_can_be_closed_again(screen: Screen) -> None:
    window = Window("grind", 1000.0)
    screen.open = False
    with pytest.raises(RenderError, match="the window has been closed: make the environment anew"):
        window.show(render(VIEW))
    window.close()
    assert not screen.open


def test_closing_the_window_destroys_it(screen: Screen) -> None:
    window = Window("grind", 1000.0)
    window.close()
    window.close()
    assert not screen.open
