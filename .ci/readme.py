"""Run the README from top to bottom, as printed: every block but that of the `make` commands.

`.ci/readme.py BIN` runs with the commands of the folder BIN, of an environment that holds the installed wheel; `make
readme` makes one. The blocks are taken out of README.md, and only the steps of the training are fewer.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

README = Path(__file__).resolve().parents[1] / "README.md"
BLOCK = re.compile(r"^```(sh|python)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
STEPS, FEW_STEPS = "1_000_000", "20_000"
READINGS = '{"mean_power": 2600, "peak_power": 2900}\n{"mean_power": 1700, "peak_power": 1900, "size_error": 1.5}\n'
"""What somebody types at the machine: the readings of the blocks of two parts."""


def scripts(readme: str) -> list[tuple[list[str], str]]:
    """What to run, in its order: an interpreter with its options, and the lines.

    The blocks of Python are one session, which goes on from block to block.
    """
    found = BLOCK.findall(readme)
    shell = [text for kind, text in found if kind == "sh" and not text.startswith("make ")]
    makes = [text for kind, text in found if kind == "sh" and text.startswith("make ")]
    session = "\n".join(text for kind, text in found if kind == "python")
    if session.count(STEPS) != 1 or not shell:
        raise SystemExit(f"README.md must train {STEPS} steps once, and have a block of shop commands")
    if readme.count("```") != 2 * len(found) or len(makes) != 1:
        raise SystemExit("README.md has a block that is not run: only the one of the make commands may be left out")
    return [(["bash", "-euxo", "pipefail", "-c"], text) for text in shell] + [
        (["python", "-c"], session.replace(STEPS, FEW_STEPS))
    ]


def main(folder: str) -> str | None:
    """Return what is wrong, or print one line and return None."""
    path = f"{Path(folder).resolve()}{os.pathsep}{os.environ['PATH']}"
    found = scripts(README.read_text(encoding="utf-8"))
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as empty:
        for interpreter, text in found:
            ended = subprocess.run(
                [*interpreter, text],
                cwd=empty,
                env={**os.environ, "PATH": path},
                input=READINGS,
                text=True,
                check=False,
            )
            if ended.returncode != 0:
                return f"README.md: {interpreter[0]} ended with status {ended.returncode} in\n{text}"
        written = {each.relative_to(empty).as_posix() for each in Path(empty).rglob("*") if each.is_file()}
    missing = {"agent.zip", *(f"my_part/{name}" for name in ("part.png", "mine.toml", "better.html"))} - written
    if missing:
        return f"README.md ran, but did not write {', '.join(sorted(missing))}"
    print(f"OK: {len(found)} scripts of README.md in {time.perf_counter() - begin:.0f} s")
    return None


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
