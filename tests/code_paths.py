"""Runs the tests that promise equal bits as other machines would: `python -m tests.code_paths [NAME ...]`.

The code of a matrix product, of numpy's and of torch's loops and of the compiled kernels is chosen by the processor.
Each path here makes them choose as another processor would, or as another number of threads does.
"""

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import llvmlite.binding as llvm

ROOT = Path(__file__).resolve().parents[1]

HASWELL = """
    64bit avx avx2 bmi bmi2 cmov crc32 cx16 cx8 f16c fma fsgsbase fxsr invpcid lzcnt mmx movbe pclmul popcnt rdrnd sahf
    sse sse2 sse3 sse4.1 sse4.2 ssse3 xsave xsaveopt
"""
"""What a Haswell can do, in the names of LLVM."""

AFFORDABLE = ("tests/behaviour/test_programs.py", "tests/machine/test_equality.py", "tests/test_layers.py")
"""Tests that take seconds in plain Python."""

Environment = dict[str, str]


class CodePath(NamedTuple):
    """Variables that lead there, and the tests that are run; all by default."""

    variables: Environment
    tests: tuple[str, ...] = ()


def threads(count: int) -> Environment:
    """As many threads as wanted, wherever a library starts some by itself."""
    return dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), str(count))


def code_paths() -> dict[str, CodePath]:
    """Those that this processor can take."""
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
    """Run the tests on the paths of those names, on all by default; the exit status."""
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
