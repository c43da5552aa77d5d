"""Write the pictures of the site anew with 128 colours, a third as long: `python docs/tools/pictures.py FOLDER`.

Exit status 1 if the site is then heavier than it may be.
"""

import io
import sys
from pathlib import Path

from PIL import Image

MOST = 12_000_000
"""Bytes of the site."""


def lighter(data: bytes) -> bytes:
    """A .png picture with 128 of its own colours, the rare ones among them, or as it is where that is no shorter."""
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
            f"the site has {weight / 1e6:.2f} MB, more than {MOST / 1e6:g}: leave a picture out, or make it smaller"
        )
