"""Part programs of shops: in inches without blanks, in lower case, with subprograms, with other dress programs."""

from pathlib import Path

from grind_env.control import read_file
from grind_env.examples import FOLDER as EXAMPLES
from grind_env.machine.job.job_file import load_job
from grind_env.shop.optimise.search_problem import Variation, variation_of
from grind_env.shop.optimise.word_editing import text_of
from grind_env.shop.search_options import SearchOptions

PLATE = (EXAMPLES / "plate_g82.nc").read_text(encoding="utf-8")
JOB = (EXAMPLES / "plate_g82.toml").read_text(encoding="utf-8")

#: the plate of the example at two stations, with its job beside it
TWO_PLATES = Path(__file__).with_name("two_plates.nc")

#: table of a job whose machine has no uncertainty: all constants are those of the catalogue
KNOWN = "\n[catalogue.uncertainty]\nnames = []\nspread = []\ncorrelation = []\n"


def known_job(folder: Path, name: str) -> Path:
    """Write the job of an example on a machine without uncertainty and return its path."""
    job = folder / f"{name}.toml"
    job.write_text((EXAMPLES / f"{name}.toml").read_text(encoding="utf-8") + KNOWN)
    return job


INCH = """%
O77 (PLATE IN INCHES)
N10 G70 G94 G90 G19 S1910 M03
N20 G00 Y.08 Z-.1 M08
N30 G00 X-1.2
N40 G01 Y0 F20.
N50 G82X9.1I-1.2Y-.0067J-.0004L0F2.5E590.55P9100D1
N60 M01
N70 G82Y-.0079J-.0002L4F2.5E354.33
N80 G80
N90 G00Y.8M09M05
N100 M30

O9100
G70 G91 G94
G90 G00 Y.8
X-4.72 Z-1.575
Y.3937
G01 Y.3929 F2.4
Z-.2 F7.52
Y.3921 F2.4
Z-1.575 F7.52
G00 Y.8
M99
%
"""

LOOP = """%
O5
N1 G71 G94 G90 G19 S1910 M03 M08
N2 G00 Y2. Z-2.5
N3 G00 X-30.
N4 G01 Y0 F500.
N5 M98 P200 L4
N6 G80
N7 G00 Y20. M09 M05
N8 M30
O200 (ONE OF FOUR STEPS)
N11 G91 G82 X230. I0 Y-.05 J-.01 L1 F60. E15000. P9100 D1 ; N12 G80 G90
N13 G00 X-30.
N14 M99
"""

DRESS = PLATE[PLATE.index("O9100") :]

FEEDS = """%
O6 (STROKES BY FEED MOVES, AND A CYCLE)
N1 G71 G94 G90 G19 S1910 M03 M08
N2 G00 Y2. Z-2.5
N3 G00 X-30.
N4 G01 Y-.01 F500.
N5 X230. F12000.
N6 X-30.
N7 Y-.02 F60.
N8 X230. F9000.
N9 G00 Y2.
N10 G00 X-30.
N11 G01 Y-.02 F500.
N12 G82 X230. I-30. Y-.05 J-.01 L1 F60. E15000. P9100 D1
N13 G80
N14 G00 Y20. M09 M05
N15 M30
"""

#: the last program has a byte order mark, and its second cycle takes the table speed over from the first
PROGRAMS: dict[str, bytes] = {
    "plate": PLATE.encode(),
    "lower": PLATE.lower().replace("\n", "\r\n").encode(),
    "inch": INCH.encode(),
    "loop": (LOOP + DRESS).encode(),
    "feeds": (FEEDS + DRESS).encode(),
    "takes_over": b"\xef\xbb\xbf" + PLATE.replace(" E9000.", "").replace("15000.", "15000").encode(),
}


def write(folder: Path, name: str, job: str = JOB) -> Path:
    """Write a program with its job beside it and return the program's path."""
    path = folder / f"{name}.nc"
    path.write_bytes(PROGRAMS[name])
    path.with_suffix(".toml").write_text(job, encoding="utf-8")
    return path


def varied(path: Path, options: SearchOptions, runs: int = 1) -> Variation:
    """Return the search problem of a program with its job beside it."""
    job = load_job(path.with_suffix(".toml"))
    return variation_of(read_file(path), text_of(path.read_bytes()), job, options, runs, 1)
