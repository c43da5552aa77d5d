"""Reduce the pictures of the site to 128 colours, a third of their size: `python docs/tools/pictures.py FOLDER`.

Exit status 1: the site is still larger than permitted.
"""

import io
import sys
from pathlib import Path

from PIL import Image

MOST = 12_000_000  #: largest permitted size of the site, bytes


def lighter(data: bytes) -> bytes:
    """Return a .png picture with 128 of its colours, also rare ones; unchanged if the result is not smaller."""
    made = io.BytesIO()
    shown = Image.open(io.BytesIO(data)).convert("RGBA")
    white = Image.new("RGBA", shown.size, "white")
    few = (
        Image.alpha_composite(white, shown)
        .convert("RGB")
        .quantize(128, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    )
    few.save(made, "PNG", optimize=True)
    return min(made.getvalue(), data, key=len)


if __name__ == "__main__":
    for path in Path(sys.argv[1]).rglob("_images/*.png"):
        path.write_bytes(lighter(path.read_bytes()))
    weight = sum(path.stat().st_size for path in Path(sys.argv[1]).rglob("*") if path.is_file())
    if weight > MOST:
        sys.exit(
            f"the site has {weight / 1e6:.2f} MB, more than {MOST / 1e6:g} MB: leave out a picture or make it smaller"
        )
