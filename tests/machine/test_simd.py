import platform
import re

import numba
import pytest

from grind_env.machine.lanes import advance_lanes


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="reads x86 assembly")
def test_the_lanes_run_in_vector_registers():
    compiled = numba.njit(error_model="numpy")(advance_lanes.py_func)
    compiled.compile("void(float64[::1])")
    (assembly,) = compiled.inspect_asm().values()
    packed, scalar = (len(re.findall(rf"\bv?(?:div|sqrt){kind}\b", assembly)) for kind in ("pd", "sd"))
    assert packed > 40
    assert scalar == 0
