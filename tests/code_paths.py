"""Runs the tests of bit-equal results as on other machines: `python -m tests.code_paths [NAME ...]`.

The processor decides which code runs in matrix products, in numpy's and torch's loops and in compiled kernels.
Each code path makes the libraries choose as on another processor or with another number of threads.
"""

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import llvmlite.binding as llvm

ROOT = Path(__file__).resolve().parents[1]

#: features of a Haswell processor, as LLVM names them
HASWELL = """
    64bit avx avx2 bmi bmi2 cmov crc32 cx16 cx8 f16c fma fsgsbase fxsr invpcid lzcnt mmx movbe pclmul popcnt rdrnd sahf
    sse sse2 sse3 sse4.1 sse4.2 ssse3 xsave xsaveopt
"""

#: tests that take seconds in plain Python
AFFORDABLE = ("tests/behaviour/test_programs.py", "tests/machine/test_equality.py", "tests/test_layers.py")

Environment = dict[str, str]


class CodePath(NamedTuple):
    """Environment variables of a code path, and the tests to run on it; all by default."""

    variables: Environment
    tests: tuple[str, ...] = ()


def threads(count: int) -> Environment:
    """Return the variables that set the number of threads of every library."""
    return dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), str(count))


def code_paths() -> dict[str, CodePath]:
    """Return the code paths that this processor can run, by name."""
    here = llvm.get_host_cpu_features()
    avx2 = {
        # the name alone would leave numba the features of this processor
        "NUMBA_CPU_NAME": "haswell",
        "NUMBA_CPU_FEATURES": ",".join(f"{'+' if name in HASWELL.split() else '-'}{name}" for name in here),
        "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR",
        "ATEN_CPU_CAPABILITY": "avx2",
        "MKL_ENABLE_INSTRUCTIONS": "AVX2",
    }
    found = {"plain-python": CodePath({"NUMBA_DISABLE_JIT": "1"}, AFFORDABLE)}
    if here.get("avx2"):
        found["haswell"] = CodePath({"OPENBLAS_CORETYPE": "Haswell", **avx2, **threads(1)})
        found["zen"] = CodePath({"OPENBLAS_CORETYPE": "Zen", **threads(2)})
    if here.get("avx512f"):
        found["skylake-x"] = CodePath({"OPENBLAS_CORETYPE": "SkylakeX", **threads(2)})
    return found


def main(names: list[str]) -> int:
    """Run the tests on the named paths, by default on all; return the exit status."""
    known = code_paths()
    unknown = [name for name in names if name not in known]
    if unknown:
        print(f"there is no path {unknown[0]}; there are {', '.join(known)}", file=sys.stderr)
        return 2
    failed = []
    for name in names or known:
        variables, tests = known[name]
        print(f"\n{name}: {' '.join(f'{key}={value:.40}' for key, value in variables.items())}", flush=True)
        command = [sys.executable, "-m", "pytest", "-q", "-n", "2", "--dist", "worksteal", "-m", "bits", *tests]
        if subprocess.run(command, cwd=ROOT, env={**os.environ, **variables}, check=False).returncode != 0:
            failed.append(name)
    print(f"\nequal bits on {len(names or known) - len(failed)} paths; not on: {', '.join(failed) or 'none'}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
