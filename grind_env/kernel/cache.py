"""Compiled kernels on disk: one file for each kernel and its argument types, checked before it is loaded.

Concurrent processes can damage the index of numba's own cache. That cache does not check the files that it loads, and
it notices edits only in the file of the kernel. Here the name of a file is the fingerprint of everything that its code
depends on: there is no index, and no file can be stale. A file begins with the SHA-256 of its name and of the rest.
A damaged or missing kernel is compiled again, and one line says so. Workers that start together compile a kernel once.

A kernel from disk contains the symbol names of the process that compiled it. LLVM uses the first of two symbols with
the same name. numba counts the symbols of each process, so names of two processes would collide; random numbers do not.

The checksum protects against damage, not against attacks: whoever can write into the folder can run code here.
"""

import contextlib
import functools
import hashlib
import logging
import multiprocessing
import os
import pickle
import secrets
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import numba
import platformdirs
from numba.core.bytecode import FunctionIdentity
from numba.core.compiler_lock import global_compiler_lock
from numba.core.runtime import rtsys

from grind_env.file_lock import alone
from grind_env.files import FileError, write_atomically
from grind_env.kernel.fingerprint import UnknownIngredient, count_functions, fingerprint

DIGEST = hashlib.sha256().digest_size
UNUSED = 30 * 24 * 3600.0  # s without use, after which a file is deleted
COMPILATION = 0.1  # s to compile one function of a kernel on one core, within a factor of two
LONG = 3.0  # s from which a compilation is announced

FunctionIdentity._unique_ids = iter(lambda: secrets.randbits(64), -1)


def cache_folder() -> Path:
    """Return the folder of compiled kernels: `kernels` under NUMBA_CACHE_DIR or the user's cache."""
    return Path(numba.config.CACHE_DIR or platformdirs.user_cache_dir("grind_env")) / "kernels"


def keep_on_disk(kernel: Any) -> None:
    """Replace the cache of a function that numba compiles by this cache."""
    if hasattr(kernel, "_cache"):
        kernel._cache = KernelCache(kernel, cache_folder())
        kernel.compile = functools.partial(_compile_once, kernel._cache, kernel.compile)
    else:
        _say(f"numba {numba.__version__} takes no cache but its own: kernels are compiled at every start")


class KernelCache:
    """The cache of one kernel. It replaces numba's `Dispatcher._cache` and has the same method names.

    The class uses these internals of numba: `FunctionIdentity._unique_ids`, `CompileResult._reduce` and `_rebuild`,
    `has_dynamic_globals` of a code library, `magic_tuple` of a code generator (platform, name and features of the CPU),
    `serialize.dumps`, `rtsys.initialize`, and the call of a dispatcher's `compile` under `global_compiler_lock`.
    """

    announced: ClassVar[bool] = False  #: whether this process has announced a compilation

    def __init__(self, kernel: Any, folder: Path) -> None:
        self._kernel, self.folder = kernel, folder
        self._prints: dict[Any, str] = {}
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)

    def has(self, signature: Any) -> bool:
        """Return whether the cache holds the kernel compiled for these types of arguments."""
        name = self._kernel.__name__.strip("<>")
        with contextlib.suppress(Exception):  # without a fingerprint there is no file
            if next(self.folder.glob(f"{name}-*.nbc"), None) is not None:  # faster than a fingerprint
                return self._path(signature, self._kernel.targetctx.codegen()).exists()
        return False

    @property
    def cache_path(self) -> str | None:
        """Folder of the cache; None if it could not be created."""
        return str(self.folder) if self.folder.is_dir() else None

    def lock(self, signature: Any) -> Path | None:
        """Return the lock file of a compilation for these argument types; None if no lock is needed or possible."""
        try:
            path = self._path(signature, self._kernel.targetctx.codegen())
        except Exception:  # `save_overload` reports the reason
            return None
        return None if path.exists() or not self.cache_path else path.with_suffix(".lock")

    def forget(self, signature: Any) -> None:
        """Forget the fingerprint for these argument types: names may be rebound before the next compilation."""
        self._prints.pop(signature, None)

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the kernel compiled for these argument types; None if it has to be compiled."""
        try:
            path = self._path(signature, target.codegen())
            content = path.read_bytes()
        except FileNotFoundError:
            self.announce()
            return None
        except Exception:  # without a fingerprint there is no file; `save_overload` reports the reason
            return None
        try:
            if _digest(path, content[DIGEST:]) != content[:DIGEST]:
                raise ValueError("damaged")
            # not `target.refresh()`, which imports SciPy: compiled code needs only the reference counting
            rtsys.initialize(target)
            compiled = numba.core.compiler.CompileResult._rebuild(target, *pickle.loads(content[DIGEST:]))
        except Exception:
            _say(f"{path} is damaged: the kernel is compiled anew")
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return compiled

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Write the kernel compiled for these argument types."""
        try:
            if compiled.library.has_dynamic_globals:
                raise UnknownIngredient("its code holds addresses of this process")
            path = self._path(signature, compiled.codegen)
            payload = numba.core.serialize.dumps(compiled._reduce())
            write_atomically(path, lambda temporary: temporary.write_bytes(_digest(path, payload) + payload))
            _delete_unused(self.folder)
        except (FileError, OSError):
            _say(f"{self.folder} cannot be written to: kernels are compiled at every start (NUMBA_CACHE_DIR moves it)")
        except Exception as error:
            _say(f"{self._kernel.__qualname__} is compiled at every start: {error}")

    def flush(self) -> None:
        """Do nothing: after a change of constants `recompile` writes a file with another name."""

    def announce(self) -> None:
        """Announce a long compilation: one line for each process, but none in worker processes."""
        seconds = compile_seconds(self._kernel)
        if seconds >= LONG and self.cache_path and not KernelCache.announced and not multiprocessing.parent_process():
            KernelCache.announced = True
            name = self._kernel.__name__
            _say(f"compiling {name}, once on this machine: about {seconds:.0f} s (kept in {self.folder})")

    def _path(self, signature: Any, codegen: Any) -> Path:
        name = self._kernel.__name__.strip("<>")
        if signature not in self._prints:
            self._prints[signature] = fingerprint(self._kernel, signature, codegen.magic_tuple())
        return self.folder / f"{name}-{self._prints[signature]}.nbc"


def compile_seconds(kernel: Any) -> float:
    """Estimate the time to compile a kernel, s."""
    return COMPILATION * count_functions(kernel)


def _compile_once(cache: KernelCache, compile_: Callable[[Any], Any], signature: Any) -> Any:
    """Load or compile a kernel; if several processes need the kernel, one compiles and the others wait."""
    with contextlib.ExitStack() as held:
        # the same order in every thread prevents a deadlock: a kernel compiles the kernels that it calls
        held.enter_context(global_compiler_lock)
        held.callback(cache.forget, signature)
        lock = cache.lock(signature)
        if lock is not None:
            cache.announce()
            with contextlib.suppress(OSError):
                held.enter_context(alone(lock))
        return compile_(signature)


def _digest(path: Path, payload: bytes) -> bytes:
    """Return the SHA-256 of name and content: a file with the name of another kernel counts as damaged."""
    return hashlib.sha256(path.name.encode() + payload).digest()


def _delete_unused(folder: Path) -> None:
    """Delete kernels and temporary files of killed writers that nobody has used for `UNUSED` seconds."""
    for path in [*folder.glob("*.nbc"), *folder.glob(".grind-*")]:
        with contextlib.suppress(OSError):
            if path.stat().st_mtime < time.time() - UNUSED:
                shutil.rmtree(path) if path.is_dir() else path.unlink()


@functools.cache
def _say(line: str) -> None:
    """Log a line once in each process, because a full disk affects every kernel."""
    logging.getLogger(__name__).warning(line)
