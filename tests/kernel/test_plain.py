"""Compilation of kernels, and functions that give the same bits as plain Python and compiled."""

import functools
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import llvmlite.binding as llvm
import numba
import pytest
from hypothesis import given
from hypothesis import strategies as st

from grind_env import examples
from grind_env.kernel import entry, inlined_rule
from grind_env.machine.job.job_file import load_job
from grind_env.machine.loops.cycle import dress_lead
from grind_env.process import equations as eq
from grind_env.process.cost import Limits, survival, volume_left
from grind_env.process.stroke_and_dress import dressed_wheel

numbers = st.floats(1e-4, 1e3)


@functools.cache
def compiled(function: Any) -> Callable[..., Any]:
    """Return a function compiled as in kernels."""
    return numba.njit(error_model="numpy")(function.py_func)


@pytest.mark.parametrize(
    ("function", "count"), [(eq.overlap_ratio, 2), (eq.blunting, 2), (eq.severity, 4), (volume_left, 2)]
)
@given(data=st.data())
def test_plain_functions_give_the_same_bits_as_compiled_ones(
    function: Callable[..., float], count: int, data: st.DataObject
) -> None:
    given_numbers = data.draw(st.lists(numbers, min_size=count, max_size=count))
    assert function(*given_numbers).hex() == compiled(function)(*given_numbers).hex()


@given(radius=st.floats(0.01, 2.0), share=st.floats(0.001, 1.0), flat=st.floats(0.0, 0.5))
def test_plain_and_compiled_dress_width_have_the_same_bits(radius: float, share: float, flat: float) -> None:
    depth = radius * share
    assert eq.dress_width(depth, radius, flat).hex() == compiled(eq.dress_width)(depth, radius, flat).hex()


@given(diameter=st.floats(200.0, 400.0), flat=st.floats(0.0, 0.5), depth=st.floats(0.001, 0.1), feed=st.floats(0.1, 20))
def test_plain_and_compiled_dressing_agree(diameter: float, flat: float, depth: float, feed: float) -> None:
    p = load_job(examples.path("plate_g82.toml")).parameters
    wheel = dressed_wheel(diameter, flat, 0.1, depth, p)
    assert wheel == compiled(dressed_wheel)(diameter, flat, 0.1, depth, p)
    assert dress_lead(wheel, feed, p) == compiled(dress_lead)(wheel, feed, p)


@given(
    values=st.tuples(st.floats(0.0, 2000.0), st.floats(0.0, 1.1), st.floats(0.01, 5.0), st.floats(-50.0, 50.0)),
    limits=st.tuples(*[st.floats(-1.0, 300.0)] * 4),
)
def test_plain_and_compiled_survival_agree(values: tuple[float, ...], limits: tuple[float, ...]) -> None:
    assert survival(*values, Limits(*limits)) == compiled(survival)(*values, Limits(*limits))


def test_the_plain_survival_compiles_nothing() -> None:
    code = (
        "import sys, numba.core.compiler as compiler; compiler.Compiler.compile_extra = None\n"
        "from grind_env.process import cost\n"
        "print(cost.survival(1.0, 0.5, 0.3, 1.0, cost.Limits(300.0, 1.0, 0.4, 5.0)) > 0.5)"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "True\n"


def half(x):
    return 0.5 * x


def quarter(x):
    return half(half(x))


def test_a_plain_python_rule_is_compiled_with_the_functions_it_calls():
    rule = inlined_rule(quarter)
    assert rule(3.0) == quarter(3.0) == 0.75
    assert numba.njit(lambda x: rule(x) + 1.0)(3.0) == 1.75
    assert type(half) is type(quarter)  # the control still uses the plain functions


def test_a_kernel_and_its_inner_kernels_share_a_scheduler_and_restore_the_default(monkeypatch, tmp_path):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    options = []
    plain = llvm.set_option
    monkeypatch.setattr(llvm, "set_option", lambda name, option: options.append(option) or plain(name, option))
    inner = entry(lambda x: x + 1.0)
    outer = entry(lambda x: inner(x) * inner(x))
    assert outer(2.0) == 9.0
    assert set(options[:-1]) == {"--pre-RA-sched=list-ilp"}
    assert options[-1] == "--pre-RA-sched=default"


def test_a_failed_compilation_restores_the_default_scheduler(monkeypatch):
    options = []
    monkeypatch.setattr(llvm, "set_option", lambda name, option: options.append(option))
    with pytest.raises(numba.core.errors.TypingError):
        entry(lambda x: x + "a")(1.0)
    assert options == ["--pre-RA-sched=list-ilp", "--pre-RA-sched=default"]
