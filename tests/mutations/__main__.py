"""Check that the tests find mistakes: put one mistake at a time into a copy of the last commit and run its tests.

    python -m tests.mutations [--least 37] [NAME ...]

A mistake is found if a test fails with it and passes without it. Results are cached for each commit in
build/mutations.json, so that an interrupted run resumes.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from grind_env.errors import GrindError
from grind_env.files import write_atomically
from grind_env.toml import read_toml

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted(Path(__file__).parent.glob("*.toml"))
BUILD = ROOT / "build"
FAILED = re.compile(r"^(?:FAILED|ERROR) (tests/.*?)(?: - .*)?$", re.MULTILINE)


class Mutation(NamedTuple):
    """Mistake in one line; `old` and `new` have no indentation, `tests` should find the mistake."""

    name: str
    file: str
    old: str
    new: str
    wrong: str
    tests: list[str]

    def applied(self, text: str) -> str:
        """Return the text of the file with the mistake."""
        if (count := text.count(self.old)) != 1:
            said = f"{self.file} has {self.old!r} {count} times"
            raise GrindError(f"{self.name}: {said}; write the same mistake into a line that occurs once")
        return text.replace(self.old, self.new)


def first_failing(tree: Path, tests: list[str]) -> str:
    """Return the first test that fails in a working tree; empty if all pass."""
    # kernels with mistakes must not get into the user's cache
    environment = {**os.environ, "PYTHONPATH": str(tree), "NUMBA_CACHE_DIR": str(BUILD / "mutations")}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "2", *tests]
    run = subprocess.run(command, cwd=tree, env=environment, check=False, capture_output=True, text=True)
    failed = FAILED.search(run.stdout)
    if run.returncode and failed is None:
        raise GrindError(f"pytest could not run {' '.join(tests)}:\n{run.stdout}{run.stderr}")
    return failed[1] if failed else ""


def finder(mutation: Mutation, commit: str) -> str:
    """Return the first test that finds a mistake in a copy of a commit; empty if none does."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        subprocess.run(["git", "clone", "--quiet", "--shared", "--no-checkout", ROOT, tree], check=True)
        subprocess.run(["git", "-C", tree, "checkout", "--quiet", "--detach", commit], check=True)
        source = tree / mutation.file
        text = source.read_text(encoding="utf-8")
        source.write_text(mutation.applied(text), encoding="utf-8")
        found = first_failing(tree, mutation.tests)
        source.write_text(text, encoding="utf-8")
        if found and first_failing(tree, [found]):
            raise GrindError(f"{mutation.name}: {found} fails without the mistake, too; fix this test first")
        return found


def main() -> int:
    """Try the mistakes; return 1 if the tests find fewer than `--least`."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="name of a mutation; default: all")
    parser.add_argument("--least", type=int, default=0, help="exit status 1 if the tests find fewer; default: 0")
    options = parser.parse_args()
    known = {each["name"]: Mutation(**each) for file in FILES for each in read_toml(file)["mutation"]}
    if unknown := {*options.names} - {*known}:
        parser.error(f"there is no mutation {min(unknown)}; there are {', '.join(known)}")
    tried = [known[name] for name in options.names or known]
    commit = subprocess.check_output(["git", "-C", ROOT, "rev-parse", "HEAD"], text=True).strip()
    BUILD.mkdir(exist_ok=True)
    path, found = BUILD / "mutations.json", 0
    kept = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    for each in tried:
        key = json.dumps([commit, *each])
        if key not in kept:
            kept[key] = finder(each, commit)
            write_atomically(path, lambda part: part.write_text(json.dumps(kept, indent=1), encoding="utf-8"))
        found += bool(kept[key])
        told = f"found by {kept[key]}" if kept[key] else f"NOT FOUND ({each.wrong}) by {' '.join(each.tests)}"
        print(f"{each.name}: {told}", flush=True)
    print(f"{found} of {len(tried)} mutations are found")
    return int(found < options.least)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except GrindError as error:
        sys.exit(f"error: {error}")
