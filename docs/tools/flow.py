"""Overview figure of the process, from E and D to the cost of a part, as an SVG: `python docs/tools/flow.py` prints it.

The figure takes its colours from the page, light or dark, and fits on a phone.
"""

from typing import NamedTuple
from xml.sax.saxutils import escape

WIDTH, HEIGHT = 400, 568
LEFT, RIGHT = 14, 208
COLUMN = 178  #: left ends and width of the two columns; lines run beside and between them
STYLE = """\
.flow { max-width: 31rem; width: 100%; height: auto; display: block; margin: 1rem auto; font-size: 12.5px; }
.flow rect { fill: var(--color-background-secondary, #f8f9fb); stroke: var(--color-foreground-border, #878787); }
.flow .ours rect { stroke: var(--color-brand-primary, #0a4bff); stroke-width: 2.5; }
.flow text { fill: var(--color-foreground-primary, #000); text-anchor: middle; }
.flow .title { font-weight: 600; font-size: 14px; }
.flow path { fill: none; stroke: var(--color-foreground-secondary, #5a5c63); stroke-width: 1.5; }
.flow .tip { fill: var(--color-foreground-secondary, #5a5c63); stroke: none; }
.flow a { text-decoration: none; }
.flow a:hover rect { stroke: var(--color-brand-content, #2757dd); }
"""


class Box(NamedTuple):
    """Step of the flow."""

    title: str
    words: str
    page: str
    """Link, relative to the page that shows the figure."""
    x: int
    y: int
    width: int = COLUMN
    height: int = 50
    ours: bool = False
    """True for E and D, which a policy chooses, and for the cost."""


BOXES = (
    Box("E", "speed of the table", "../control/index.html", LEFT, 4, height=44, ours=True),
    Box("D", "dresses in the cycle", "../howto/dress-words.html", RIGHT, 4, height=44, ours=True),
    Box("Stroke", "depth of cut, removal rate", "cutting.html", LEFT, 76),
    Box("Dress", "lead, depth, passes", "dressing.html", RIGHT, 76),
    Box("Force and power", "chips, ploughing, flats", "cutting.html", LEFT, 154),
    Box("Wheel", "wear flats, grains, loading", "#the-state", RIGHT, 154),
    Box("Heat", "temperature, burn ratio", "heat.html", LEFT, 238),
    Box("Wear", "sliding, fracture, G-ratio", "wear.html", RIGHT, 238),
    Box("Size", "deflection, wear, growth", "cutting.html", LEFT, 316),
    Box("Roughness", "dress, removal rate, wear", "roughness.html", RIGHT, 316),
    Box("Time", "strokes, dresses", "../control/index.html", LEFT, 406, width=112, height=64),
    Box("Limits", "power, temperature, size, Ra:", "../howto/job-file.html#what-makes-a-part-good", 138, 406, 248, 64),
    Box(
        "Cost of a good part",
        "time + wheel + dresses + expected scrap",
        "../api/process.html",
        LEFT,
        510,
        372,
        54,
        True,
    ),
)
ARROWS = (
    "M103 48 V72",  # E to the stroke
    "M297 48 V72",  # D to the dress
    "M103 126 V150",  # stroke to force
    "M297 126 V150",  # dress to wheel
    "M208 170 H196",  # a dull wheel to the force
    "M103 204 V234",  # power to heat
    "M297 238 V208",  # wear to wheel
    "M200 256 H204",  # force and heat to wear
    "M200 196 V402",  # force and heat to the limits
    "M103 288 V312",  # heat to the growth of the part
    "M386 179 H394 V341 H390",  # wheel to roughness
    "M164 366 V402",  # size to the limits
    "M297 366 V402",  # roughness to the limits
    "M14 26 H6 V438 H10",  # E to time
    "M70 470 V506",  # time to cost
    "M262 470 V506",  # limits to cost
)
#: lines without a tip, which join the line from force and heat to the limits
JOINTS = ("M192 196 H200", "M192 268 H200")
SECOND = {"Limits": "how likely the part is scrap", "Time": "and loading"}  #: third lines of boxes that have one


def flow() -> str:
    """Return the figure, one `svg` element with its style."""
    parts = [
        f'<svg class="flow" viewBox="0 0 {WIDTH} {HEIGHT}" xmlns="http://www.w3.org/2000/svg" role="group"'
        ' aria-label="From table speed and dresses to the cost of a part">',
        f"<style>{STYLE}</style>",
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="4" refY="4" markerWidth="5.5" markerHeight="5.5"'
        ' orient="auto"><path class="tip" d="M0 0 L8 4 L0 8 z"/></marker></defs>',
        *(f'<path d="{line}"/>' for line in JOINTS),
        *(f'<path d="{line}" marker-end="url(#tip)"/>' for line in ARROWS),
        *map(_box, BOXES),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _box(box: Box) -> str:
    middle, second = box.x + box.width // 2, SECOND.get(box.title)
    top = box.y + box.height // 2 - (13 if second else 4)
    lines = [(top, "title", box.title), (top + 18, "", box.words)]
    if second:
        lines.append((top + 34, "", second))
    texts = "".join(f'<text x="{middle}" y="{y}" class="{kind}">{escape(text)}</text>' for y, kind, text in lines)
    return (
        f'<a href="{box.page}" class="{"ours" if box.ours else ""}">'
        f'<rect x="{box.x}" y="{box.y}" width="{box.width}" height="{box.height}" rx="5"/>{texts}</a>'
    )


if __name__ == "__main__":
    print(flow(), end="")
