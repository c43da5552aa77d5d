"""How kernels are compiled."""

import llvmlite.binding as llvm
import numba
import pytest

from grind_env.kernel import entry, inlined_rule


def half(x):
    return 0.5 * x


def quarter(x):
    return half(half(x))


def test_a_rule_in_plain_python_is_compiled_with_what_it_calls():
    rule = inlined_rule(quarter)
    assert rule(3.0) == quarter(3.0) == 0.75
    assert numba.njit(lambda x: rule(x) + 1.0)(3.0) == 1.75
    assert type(half) is type(quarter)  # the control goes on with plain functions


def test_a_kernel_and_those_that_it_calls_are_scheduled_alike_and_nothing_after_them(monkeypatch, tmp_path):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    options = []
    plain = llvm.set_option
    monkeypatch.setattr(llvm, "set_option", lambda name, option: options.append(option) or plain(name, option))
    inner = entry(lambda x: x + 1.0)
    outer = entry(lambda x: inner(x) * inner(x))
    assert outer(2.0) == 9.0
    assert set(options[:-1]) == {"--pre-RA-sched=list-ilp"}
    assert options[-1] == "--pre-RA-sched=default"


def test_a_compilation_that_fails_leaves_the_scheduler_as_it_was(monkeypatch):
    options = []
    monkeypatch.setattr(llvm, "set_option", lambda name, option: options.append(option))
    with pytest.raises(numba.core.errors.TypingError):
        entry(lambda x: x + "a")(1.0)
    assert options == ["--pre-RA-sched=list-ilp", "--pre-RA-sched=default"]
