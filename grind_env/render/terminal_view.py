"""A view as text: the facts of the picture, for a terminal or a log."""

from grind_env.message_text import printable
from grind_env.render.picture_data import EpisodePicture
from grind_env.render.strip_chart_data import Strip, strips_of

LEVELS = "▁▂▃▄▅▆▇█"
SHOWN = 60  #: number of past blocks for which a line has room


def panel(view: EpisodePicture) -> str:
    """Return the view as lines of at most 100 characters; each bar is a block, each digit its number of dresses."""
    wheel, extent = view.wheel, view.extent
    title = f"{extent.title}: block {view.number} of {extent.blocks}"
    lines = [
        ("", title),
        *zip(("block", *[""] * view.text.count("\n")), (view.text or "none run yet").split("\n"), strict=True),
        ("wheel", f"radius {0.5 * wheel.ds:.2f} mm, {view.radius_lost:.2f} mm gone"),
        ("", f"wear-flat area {100.0 * wheel.A:.2f} %, loading {100.0 * wheel.lam:.0f} %"),
        ("diamond", f"worn {wheel.wd:.2f} mm flat"),
        ("part", f"{view.part.description}, {1000.0 * view.part.left:.0f} µm left"),
        ("", view.verdict),
        *((strip.name, _line(strip)) for strip in strips_of(view)),
        ("dresses D", _dresses(view)),
        ("cost", f"{view.price}, {view.scrapped} of {view.finished_parts} parts scrap"),
    ]
    return printable("\n".join(f"{name:<18}{text}".rstrip() for name, text in lines if name or text))


def _line(strip: Strip) -> str:
    bars = "".join(
        LEVELS[min(int(strip.height(value) * len(LEVELS)), len(LEVELS) - 1)] for value in strip.values[-SHOWN:]
    )
    return f"{strip.latest + ' ' + strip.unit if bars else '':<22}{bars}"


def _dresses(view: EpisodePicture) -> str:
    count = sum(block.executions for block in view.ground)
    marks = "".join(str(block.executions) if block.executions else "·" for block in view.ground[-SHOWN:])
    return f"{count:<22}{marks}"
