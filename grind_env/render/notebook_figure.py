"""A figure of matplotlib that notebooks show without pyplot."""

import io

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

DPI = 130  #: resolution of .png files and of pictures in a notebook, dpi


class ShownFigure(Figure):
    """A figure outside of pyplot: a notebook shows it once, and nothing has to close it."""

    def __init__(self, width: float, height: float) -> None:
        super().__init__(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=DPI)
        return picture.getvalue()
