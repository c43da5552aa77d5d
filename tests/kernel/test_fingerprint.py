"""The fingerprint of a kernel changes with each of its ingredients and with nothing else."""

import importlib
import io
import itertools
import os
import pkgutil
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import redirect_stdout
from enum import Enum, IntEnum
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import llvmlite
import numba
import numpy as np
import pytest

import grind_env
import grind_env.policies.scripted
from grind_env.kernel import entry, inlined
from grind_env.kernel.fingerprint import UnknownIngredient, fingerprint
from grind_env.machine.loops.stroke_loops import Loops

Maker = Callable[[int], Any]  # from a variant to the value of `thing` in a kernel


def defined(source: str, **names: Any) -> Any:
    """Return the `kernel` that a source defines; variants share no object."""
    exec(source, names)
    return names["kernel"]


def module(name: str, **attributes: Any) -> ModuleType:
    made = ModuleType(name)
    vars(made).update(attributes)
    return made


def record(name: str, fields: str, **options: Any) -> Any:
    return NamedTuple(name, [(field, float) for field in fields.split()])


def with_default(value: float) -> Any:
    class Setting(NamedTuple):
        depth: float = value

    return Setting


def adder(variant: int) -> Any:
    return inlined(defined(f"def kernel(x): return x + {variant}"))


def caller(variant: int) -> Any:
    return inlined(defined("def kernel(x): return add(x)", add=adder(variant)))


class Toolpath:
    """A class that compiled code cannot use."""


THINGS: dict[str, Maker] = {
    "int": lambda k: k,
    "type of a number": lambda k: (1, 1.0, True)[k],
    "sign of zero": lambda k: (0.0, -0.0)[k],
    "float": lambda k: 0.1 + k,
    "text": lambda k: "ab"[k],
    "bytes": lambda k: bytes([k]),
    "tuple": lambda k: (1, (2, k)),
    "list": lambda k: [1, [2, k]],
    "tuple or list": lambda k: ((1, 2), [1, 2])[k],
    "dict": lambda k: {"a": {"b": k}},
    "set": lambda k: frozenset({"a", "b", "cd"[k]}),
    "number of NumPy": lambda k: np.float64(k),
    "width of a number": lambda k: (np.float64, np.float32)[k](1.0),
    "elements of an array": lambda k: np.array([0.0, k]),
    "shape of an array": lambda k: np.zeros(((2, 3), (3, 2))[k]),
    "order of an array": lambda k: np.zeros((2, 3), order=("C", "F")[k]),
    "dtype of an array": lambda k: np.zeros(2, dtype=("f8", "i8")[k]),
    "fields of an array": lambda k: np.zeros(2, dtype=[("ab"[k], "f8")]),
    "dtype": lambda k: np.dtype(("f8", "f4")[k]),
    "type of NumPy": lambda k: (np.float64, np.float32)[k],
    "fields of a named tuple": lambda k: record("Cut", ("depth feed", "feed depth")[k]),
    "default of a named tuple": lambda k: with_default(float(k)),
    "name of a named tuple": lambda k: record(("Cut", "Pick")[k], "depth feed"),
    "named tuple": lambda k: record("Cut", "depth feed")(1.0, k),
    "type of a named tuple": lambda k: record("Cut", ("depth feed", "feed depth")[k])(1.0, 2.0),
    "enum": lambda k: Enum("Side", {"PRIMARY": k, "SECONDARY": 2}),
    "kind of enum": lambda k: (Enum, IntEnum)[k]("Side", {"PRIMARY": 1}),
    "member of an enum": lambda k: list(IntEnum("Side", {"PRIMARY": 1, "SECONDARY": 2}))[k],
    "value of a member": lambda k: next(iter(IntEnum("Side", {"PRIMARY": k}))),
    "compiled function": adder,
    "compiled function of a compiled function": caller,
    "options of a compiled function": lambda k: numba.njit(fastmath=bool(k))(defined("def kernel(x): return x + 1")),
    "entry": lambda k: entry(defined(f"def kernel(x): return x + {k}")),
    "function of a library": lambda k: (np.exp, np.log)[k],
    "type of numba": lambda k: (numba.types.float64, numba.types.float32)[k],
    "exception": lambda k: (ValueError, KeyError)[k],
}

NAMED: dict[str, Callable[[Any], Any]] = {
    "global": lambda thing: defined("def kernel(x): return x, thing", thing=thing),
    "global in a comprehension": lambda thing: defined("def kernel(x): return [thing for _ in x]", thing=thing),
    "global in a function inside": lambda thing: defined("def kernel(x): return (lambda: thing)()", thing=thing),
    "closure": lambda thing: defined(
        "def within(thing):\n  def kernel(x): return x, thing\n  return kernel\nkernel = within(value)", value=thing
    ),
    "closure of a function inside": lambda thing: defined(
        "def within(thing):\n  def kernel(x): return (lambda: thing)()\n  return kernel\nkernel = within(value)",
        value=thing,
    ),
    "default": lambda thing: defined("def kernel(x, y=thing): return x, y", thing=thing),
    "keyword default": lambda thing: defined("def kernel(x, *, y=thing): return x, y", thing=thing),
    "attribute of a module": lambda thing: defined(
        "def kernel(x): return x, rules.thing", rules=module("rules", thing=thing)
    ),
    "attribute of a module in a closure": lambda thing: defined(
        "def within(rules):\n  def kernel(x): return x, rules.thing\n  return kernel\nkernel = within(value)",
        value=module("rules", thing=thing),
    ),
    "attribute of a module of a package": lambda thing: defined(
        "def kernel(x): return x, machine.rules.thing", machine=module("machine", rules=module("rules", thing=thing))
    ),
    "compiled function": lambda thing: defined("def kernel(x): return g(x)", g=inlined(NAMED["global"](thing))),
    "compiled function in a closure": lambda thing: NAMED["closure"](inlined(NAMED["closure"](thing))),
}


@pytest.mark.parametrize("way", NAMED)
def test_a_fingerprint_depends_on_every_value_the_kernel_names(way: str) -> None:
    for kind, make in THINGS.items():
        first, again, other = (fingerprint(NAMED[way](make(variant))) for variant in (0, 0, 1))
        assert first == again, kind
        assert first != other, kind


@pytest.mark.parametrize(
    ("source", "other"),
    [
        ("def kernel(x): return x + 1", "def kernel(x): return x - 1"),
        ("def kernel(x): return x + 1", "def kernel(x): return x + 2"),
        ("def kernel(x): return x + 1", "def kernel(x): return x + 1.0"),
        ("def kernel(x): return x * 0.0", "def kernel(x): return x * -0.0"),
        ("def kernel(x): return x, (1, (2, 3))", "def kernel(x): return x, (1, (2, 4))"),
        ("def kernel(x): return x in {1, 2}", "def kernel(x): return x in {1, 3}"),
        ("def kernel(x): return x.depth", "def kernel(x): return x.feed"),
        ("def kernel(x): return (lambda y: y + 1)(x)", "def kernel(x): return (lambda y: y + 2)(x)"),
        ("def kernel(x): return [y + 1 for y in x]", "def kernel(x): return [y + 2 for y in x]"),
        ("def kernel(x, y): return x", "def kernel(y, x): return x"),
        ("def kernel(x, y=1): return x", "def kernel(x, *, y=1): return x"),
        ("def kernel(x): return min(x)", "min = max\ndef kernel(x): return min(x)"),
    ],
)
def test_code_is_part_of_the_fingerprint(source: str, other: str) -> None:
    assert fingerprint(defined(source)) == fingerprint(defined(f"# a remark\n\n{source}  # another"))
    assert fingerprint(defined(source)) != fingerprint(defined(other))


def test_a_fingerprint_ignores_values_the_kernel_does_not_name() -> None:
    source = "def kernel(x): return x.thing + rules.limit"
    one = defined(source, unused=1, rules=module("rules", limit=1.0, unused=1))
    other = defined(source, unused=2, rules=module("rules", limit=1.0, unused=2))
    assert fingerprint(one) == fingerprint(other)


def test_an_attribute_may_share_its_name_with_an_unknown_global() -> None:
    fingerprint(defined("def kernel(x): return x.thing", thing=threading.Lock()))


def test_a_function_shared_with_an_unknown_global_changes_the_fingerprint() -> None:
    def found(variant: int) -> str:
        add = adder(variant)
        thing = inlined(defined("def kernel(x): return add(x), lock", add=add, lock=threading.Lock()))
        return fingerprint(defined("def kernel(x): return x.thing, add(x)", thing=thing, add=add))

    assert found(0) == found(0) != found(1)


def test_functions_that_call_each_other_have_a_fingerprint() -> None:
    def pair(step: int) -> Any:
        names: dict[str, Any] = {}
        exec(f"def kernel(x): return other(x - {step})\ndef other(x): return kernel(x) if x > 0 else x", names)
        names["other"], names["kernel"] = inlined(names["other"]), inlined(names["kernel"])
        return names["kernel"]

    assert fingerprint(pair(1)) == fingerprint(pair(1)) != fingerprint(pair(2))


@pytest.mark.parametrize(
    "thing",
    [object(), threading.Lock(), lambda x: x, defined, Path(), np.array([None]), Toolpath, {"a": [object()]}],
    ids=lambda thing: type(thing).__name__,
)
@pytest.mark.parametrize("way", ["global", "closure", "attribute of a module", "compiled function"])
def test_an_ingredient_of_unknown_content_is_refused_by_name(thing: object, way: str) -> None:
    with pytest.raises(UnknownIngredient, match=r"thing in \S*kernel is of type \w+,"):
        fingerprint(NAMED[way](thing))


CONDITIONS = {
    "named tuple": [numba.typeof(record("Cut", fields)(1.0, 2.0)) for fields in ("depth feed", "feed depth")],
    "mixed named tuple": [numba.typeof(record("Cut", fields)(1, 2.0)) for fields in ("depth feed", "feed depth")],
    "number": [numba.types.float64, numba.types.float32, numba.types.Omitted(1.0), numba.types.Omitted(2.0)],
    "array": [numba.typeof(np.zeros(shape, dtype)) for shape in (2, (2, 2)) for dtype in ("f8", "i8")],
    "layout": [numba.typeof(np.zeros((4, 4))), numba.typeof(np.zeros((4, 4)).T), numba.typeof(np.zeros((4, 4))[::2])],
    "record": [numba.typeof(np.zeros(2, [(name, "f8")])) for name in "ab"],
    "CPU": ["haswell", "skylake-avx512"],
}


@pytest.mark.parametrize("kind", CONDITIONS)
def test_types_of_arguments_and_the_cpu_are_part_of_the_fingerprint(kind: str) -> None:
    kernel = defined("def kernel(x): return x")
    found = [fingerprint(kernel, (condition,)) for condition in CONDITIONS[kind]]
    assert len(set(found)) == len(found)


@pytest.mark.parametrize(
    ("owner", "name", "value"),
    [
        (numba, "__version__", "0.1"),
        (llvmlite, "__version__", "0.1"),
        (np, "__version__", "0.1"),
        (sys, "version", "3.99"),
        (numba.config, "OPT", 1),
        (numba.config, "LOOP_VECTORIZE", 0),
        (numba.config, "SLP_VECTORIZE", 1),
        (numba.config, "BOUNDSCHECK", 1),
        (numba.config, "CPU_NAME", "haswell"),
        (numba.config, "CPU_FEATURES", "+avx2"),
    ],
)
def test_the_compiler_is_part_of_the_fingerprint(
    owner: Any, name: str, value: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    kernel = defined("def kernel(x): return x")
    before = fingerprint(kernel)
    monkeypatch.setattr(owner, name, value)
    assert fingerprint(kernel) != before


def test_fingerprints_agree_across_processes_until_the_kernel_package_changes(
    tmp_path: Path,
) -> None:
    shutil.copytree(
        Path(grind_env.__file__).parent, tmp_path / "grind_env", ignore=shutil.ignore_patterns("__pycache__")
    )
    rooms = ("envs.transition", "process.process_interface", "envs.task_gauges", "machine.loops.machine_lanes")
    names = tuple(f"grind_env.{room}" for room in rooms)
    script = (
        "import importlib; from grind_env.kernel.fingerprint import fingerprint\n"
        "thing = frozenset(map(str, range(50)))\ndef kernel(x): return x in thing, x in {'a', 'b', 'c', 'd'}\n"
        f"kernels = [vars(importlib.import_module(name)) for name in {names}]\n"
        "step = kernels[0]['step_of'](kernels[1]['PROCESS'], kernels[2]['GAUGE'], True)\n"
        "print(fingerprint(step), fingerprint(kernels[3]['as_they_come']), fingerprint(kernel))"
    )

    def found() -> list[str]:
        path = os.pathsep.join([str(tmp_path), *sys.path])
        environment = {**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": "1"}
        command = [sys.executable, "-c", script]
        run = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
        return run.stdout.split()

    before = found()
    with redirect_stdout(io.StringIO()) as here:
        exec(script, {"__name__": "__main__"})
    assert before == here.getvalue().split()
    with (tmp_path / "grind_env/kernel/exp_log.py").open("a", encoding="utf-8") as file:
        file.write("# an intrinsic might be different\n")
    assert not set(before) & set(found())


def test_no_two_entries_share_a_fingerprint() -> None:
    modules = [
        importlib.import_module(found.name)
        for package in (grind_env, grind_env.policies.scripted)
        for found in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    ]
    named = itertools.chain.from_iterable(vars(module).values() for module in modules)
    things = itertools.chain.from_iterable(thing if isinstance(thing, Loops) else (thing,) for thing in named)
    entries = {thing for thing in things if numba.extending.is_jitted(thing) and thing.targetoptions.get("nogil")}
    assert len(entries) > 20
    assert len({fingerprint(kernel) for kernel in entries}) == len(entries)
