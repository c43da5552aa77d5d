"""A background process that compiles kernels into the cache on disk, one after the other.

A kernel is sent through a pipe. Functions of modules are sent by name, closures by their code and the values around
them. The background process ends with its parent, which closes the pipe.
"""

import atexit
import functools
import importlib
import io
import marshal
import multiprocessing
import os
import pickle
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from queue import SimpleQueue
from types import CellType, FunctionType, ModuleType
from typing import Any, BinaryIO, ClassVar

from numba.extending import is_jitted

from grind_env.kernel.fingerprint import names_in

#: environment variables of tests and of cluster workers; these start no background process
WORKERS = "PYTEST_CURRENT_TEST", "RAY_RAYLET_PID"
LENGTH = 8  #: number of bytes that hold the length of a message


class Background:
    """The background process that compiles for this process."""

    process: ClassVar[subprocess.Popen[bytes] | None] = None
    #: whether a kernel could be sent; a key is a kernel with the types of its arguments
    sent: ClassVar[dict[Any, bool]] = {}
    queue: ClassVar[SimpleQueue[bytes]] = SimpleQueue()

    @classmethod
    def compiles(cls, kernel: Any, types: tuple[Any, ...], folder: Path) -> bool:
        """Send a kernel to be compiled for these types of arguments; return whether the background compiles it."""
        if multiprocessing.parent_process() or any(name in os.environ for name in WORKERS):
            return False
        if (kernel, types) not in cls.sent:
            cls.sent[kernel, types] = os.access(folder, os.W_OK) and cls._send(kernel, types)
        return cls.sent[kernel, types] and cls.process is not None and cls.process.poll() is None

    @classmethod
    def _send(cls, *message: Any) -> bool:
        try:
            cls.queue.put(packed(message))
            if cls.process is None:
                environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))}
                nowhere = subprocess.DEVNULL
                command = [sys.executable, "-m", __name__]
                pipe = subprocess.PIPE
                cls.process = subprocess.Popen(command, stdin=pipe, stdout=nowhere, stderr=nowhere, env=environment)
                atexit.register(cls._end, cls.process)
                threading.Thread(target=cls._write, args=(cls.process.stdin,), daemon=True).start()
        except Exception:  # pickling an object of the kernel may raise any error
            return False
        return True

    @staticmethod
    def _end(process: subprocess.Popen[bytes]) -> None:
        process.kill()
        process.wait()

    @classmethod
    def _write(cls, stream: BinaryIO) -> None:
        """Write the queued messages into the pipe; a write may wait for the background process."""
        with suppress(OSError):
            while True:
                message = cls.queue.get()
                stream.write(len(message).to_bytes(LENGTH, "big") + message)
                stream.flush()


class Packer(pickle.Pickler):
    """Pickler for compiled functions and closures."""

    def reducer_override(self, value: Any) -> Any:
        """Return how a function or module is rebuilt; pickle itself handles all other values."""
        if isinstance(value, ModuleType):
            return importlib.import_module, (value.__name__,)
        if is_jitted(value) and not _has_name(value, value.py_func):
            return (_inlined if "forceinline" in value.targetoptions else _entry), (value.py_func,)
        if is_jitted(value):
            return _named, (value.py_func.__module__, value.py_func.__qualname__)
        if isinstance(value, FunctionType) and not _has_name(value, value):
            return _function, _parts(value)
        return NotImplemented


def packed(value: Any) -> bytes:
    """Return a value as pickled bytes.

    Raises:
        Exception: the value holds an object that cannot be pickled.
    """
    file = io.BytesIO()
    Packer(file).dump(value)
    return file.getvalue()


def _parts(function: FunctionType) -> tuple[Any, ...]:
    """Return the arguments of `_function` to rebuild a function; `own` holds globals that differ from its module's."""
    module = importlib.import_module(function.__module__)
    own = {
        name: function.__globals__[name]
        for name in names_in(function.__code__)
        if name in function.__globals__ and vars(module).get(name, function) is not function.__globals__[name]
    }
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    code, names = marshal.dumps(function.__code__), (function.__module__, function.__qualname__)
    return code, *names, function.__defaults__, function.__kwdefaults__, cells, own


def _function(
    code: bytes, module: str, qualname: str, defaults: Any, kwdefaults: Any, cells: list[Any], own: dict[str, Any]
) -> FunctionType:
    found = marshal.loads(code)
    names = vars(importlib.import_module(module))
    made = FunctionType(found, {**names, **own} if own else names, found.co_name, defaults, tuple(map(CellType, cells)))
    made.__module__, made.__qualname__, made.__kwdefaults__ = module, qualname, kwdefaults
    return made


def _named(module: str, qualname: str) -> Any:
    return functools.reduce(getattr, qualname.split("."), importlib.import_module(module))


def _has_name(value: Any, function: FunctionType) -> bool:
    """Return whether another process can import a value by the name of its function."""
    try:
        return function.__module__ != "__main__" and _named(function.__module__, function.__qualname__) is value
    except AttributeError:
        return False


def _entry(function: FunctionType) -> Any:
    from grind_env.kernel import entry

    return entry(function)


def _inlined(function: FunctionType) -> Any:
    from grind_env.kernel import inlined

    return inlined(function)


def main() -> None:
    """Compile the kernels that come through the pipe, until the parent closes the pipe."""
    if hasattr(os, "nice"):
        os.nice(10)
    todo: SimpleQueue[bytes] = SimpleQueue()
    threading.Thread(target=_receive, args=(todo,), daemon=True).start()
    while True:
        kernel, types = pickle.loads(todo.get())  # safe: the parent process sends it
        kernel.compile(types)
        if not kernel._cache.has(types):  # the cache cannot write: this process ends, and the parent compiles
            return


def _receive(todo: SimpleQueue[bytes]) -> None:
    while len(length := sys.stdin.buffer.read(LENGTH)) == LENGTH:
        todo.put(sys.stdin.buffer.read(int.from_bytes(length, "big")))
    os._exit(0)


if __name__ == "__main__":
    main()
