"""Compiled kernels on disk: a file for each kernel and each kind of arguments, checked before it is loaded.

numba's own cache has an index that processes which write at once can spoil, loads whatever the files hold, and
notices edits in the file of the kernel alone. Here the name of a file is the fingerprint of all that its code depends
on, so there is no index and nothing can be stale, and the file begins with the SHA-256 of its name and of the rest.
Whatever happens to the files, a kernel can be compiled anew, and one line says so. Of workers that start at once, each
kernel is compiled by one.

A kernel from disk brings the symbols of the process that compiled it, and of two with one name LLVM takes the first,
whatever the other holds. numba numbers them, so that those of two processes meet: here the numbers are drawn.

The checksum is against damage, not against malice: who may write into the folder may run code here.
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

from grind_env.files import FileError, write_atomically
from grind_env.kernel.fingerprint import UnknownIngredient, count_functions, fingerprint
from grind_env.lock import alone

DIGEST = hashlib.sha256().digest_size
UNUSED = 30 * 24 * 3600.0  # s, after which a file is deleted
COMPILATION = 0.1  # s of one core for each function that a kernel is made of, within a factor of two
LONG = 3.0  # s that somebody waits without wondering

FunctionIdentity._unique_ids = iter(lambda: secrets.randbits(64), -1)


def cache_folder() -> Path:
    """Where kernels are kept: the folder `kernels` under NUMBA_CACHE_DIR or the user's cache."""
    return Path(numba.config.CACHE_DIR or platformdirs.user_cache_dir("grind_env")) / "kernels"


def keep_on_disk(kernel: Any) -> None:
    """Give a function that numba compiles this cache."""
    if hasattr(kernel, "_cache"):
        kernel._cache = KernelCache(kernel, cache_folder())
        kernel.compile = functools.partial(_compile_once, kernel._cache, kernel.compile)
    else:
        _say(f"numba {numba.__version__} takes no cache but its own: kernels are compiled at every start")


class KernelCache:
    """The cache of one kernel, in the place of numba's own (`Dispatcher._cache`, which sets the names of its methods).

    Of numba's internals it uses `FunctionIdentity._unique_ids`, `CompileResult._reduce` and `_rebuild`,
    `has_dynamic_globals` of a code library, `magic_tuple` of a code generator (platform, name and features of the CPU)
    `serialize.dumps`, `rtsys.initialize`, and that a dispatcher calls its `compile`, under `global_compiler_lock`.
    """

    announced: ClassVar[bool] = False
    """Has this process said that it compiles?"""

    def __init__(self, kernel: Any, folder: Path) -> None:
        self._kernel, self.folder = kernel, folder
        self._prints: dict[Any, str] = {}
        with contextlib.suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)

    def has(self, signature: Any) -> bool:
        """Return whether the cache holds the kernel compiled for these types of arguments."""
        name = self._kernel.__name__.strip("<>")
        with contextlib.suppress(Exception):  # there cannot be a file
            if next(self.folder.glob(f"{name}-*.nbc"), None) is not None:  # a fingerprint takes longer
                return self._path(signature, self._kernel.targetctx.codegen()).exists()
        return False

    @property
    def cache_path(self) -> str | None:
        """The folder; None where it cannot be made."""
        return str(self.folder) if self.folder.is_dir() else None

    def lock(self, signature: Any) -> Path | None:
        """What is held while the kernel is compiled for these types of arguments; None if it need not be, or cannot."""
        try:
            path = self._path(signature, self._kernel.targetctx.codegen())
        except Exception:  # `save_overload` says why it has no file
            return None
        return None if path.exists() or not self.cache_path else path.with_suffix(".lock")

    def forget(self, signature: Any) -> None:
        """Take the fingerprint anew at the next compilation, in which names may be bound to something else."""
        self._prints.pop(signature, None)

    def load_overload(self, signature: Any, target: Any) -> Any:
        """The compiled kernel for these types of arguments; None if it has to be compiled."""
        try:
            path = self._path(signature, target.codegen())
            content = path.read_bytes()
        except FileNotFoundError:
            self.announce()
            return None
        except Exception:  # there cannot be a file: `save_overload` says why
            return None
        try:
            if _digest(path, content[DIGEST:]) != content[:DIGEST]:
                raise ValueError("damaged")
            # of what `target.refresh()` imports, SciPy with it, compiled code needs the counting of references alone
            rtsys.initialize(target)
            compiled = numba.core.compiler.CompileResult._rebuild(target, *pickle.loads(content[DIGEST:]))
        except Exception:
            _say(f"{path} is damaged: the kernel is compiled anew")
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        return compiled

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Write what was compiled for these types of arguments."""
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
        """Nothing: what `recompile` makes of changed constants has another name."""

    def announce(self) -> None:
        """Say that it takes a while, if it does; one line a process, and none for each of many workers."""
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
    """Load or compile a kernel; of processes that want one at a time, one compiles it and the others wait for it."""
    with contextlib.ExitStack() as held:
        # in this order in every thread: a kernel compiles those that it calls
        held.enter_context(global_compiler_lock)
        held.callback(cache.forget, signature)
        lock = cache.lock(signature)
        if lock is not None:
            cache.announce()
            with contextlib.suppress(OSError):
                held.enter_context(alone(lock))
        return compile_(signature)


def _digest(path: Path, payload: bytes) -> bytes:
    """Of the name, too: a file under the name of another kernel is no better than a damaged one."""
    return hashlib.sha256(path.name.encode() + payload).digest()


def _delete_unused(folder: Path) -> None:
    """Delete kernels of former versions, and what writers that were killed have left."""
    for path in [*folder.glob("*.nbc"), *folder.glob(".grind-*")]:
        with contextlib.suppress(OSError):
            if path.stat().st_mtime < time.time() - UNUSED:
                shutil.rmtree(path) if path.is_dir() else path.unlink()


@functools.cache
def _say(line: str) -> None:
    """Once a process: a full disk refuses every kernel."""
    logging.getLogger(__name__).warning(line)
