import platform
import re

import llvmlite.binding as llvm
import numba
import pytest

from grind_env.machine.loops.stroke_loops import Loops
from tests.batches import FEEDS, PLUNGES, TRAVERSES
from tests.examples import nightly

pytestmark = pytest.mark.bits


@pytest.fixture(scope="module", params=[PLUNGES, nightly(FEEDS), nightly(TRAVERSES)], ids=["G82", "G81", "G83"])
def assembly(request: pytest.FixtureRequest) -> str:
    if platform.machine() not in ("x86_64", "AMD64"):
        pytest.skip("reads x86 assembly")
    loops: Loops = request.param
    compiled = numba.njit(error_model="numpy")(loops.advance_lanes.py_func)
    compiled.compile("void(float64[::1])")
    (text,) = compiled.inspect_asm().values()
    return str(text)


def test_the_lanes_run_in_vector_registers(assembly: str):
    packed, scalar = (len(re.findall(rf"\bv?(?:div|sqrt){kind}\b", assembly)) for kind in ("pd", "sd"))
    assert packed > 24
    assert scalar == 0


def test_no_register_is_wider_than_the_processor_supports(assembly: str):
    features = numba.config.CPU_FEATURES or llvm.get_host_cpu_features().flatten()
    widths = set(re.findall(r"[xyz]mm", assembly))
    assert "ymm" in widths or "zmm" in widths
    # LLVM need not use the widest
    assert "zmm" not in widths or "+avx512f" in features.split(",")


def test_multiplication_and_addition_are_rounded_one_by_one(assembly: str):
    assert not re.search(r"\bvfn?m(?:add|sub)", assembly)
