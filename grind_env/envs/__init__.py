"""The Gymnasium environments: one id per task."""

import sys
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

GYMNASIUM = "gymnasium"


def register() -> None:
    """Register all ids with Gymnasium: now, or when Gymnasium is imported, because most commands do not need it."""
    if GYMNASIUM in sys.modules:
        import_module("grind_env.envs.registration")
    else:
        sys.meta_path.insert(0, _Awaiting())


class _Awaiting:
    """Import finder that lets later finders find Gymnasium and registers the ids at the end of its import."""

    def find_spec(self, fullname: str, path: Any, target: ModuleType | None = None) -> ModuleSpec | None:
        if fullname != GYMNASIUM:
            return None
        after = sys.meta_path[sys.meta_path.index(self) + 1 :]
        spec = next(filter(None, (finder.find_spec(fullname, path, target) for finder in after)), None)
        if spec is not None and spec.loader is not None:
            execute = spec.loader.exec_module

            def exec_module(module: ModuleType) -> None:
                execute(module)
                register()

            spec.loader.exec_module = exec_module  # type: ignore[method-assign]
        return spec
