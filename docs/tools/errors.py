"""Page of all errors that the package raises for mistakes of users."""

import pkgutil
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import grind_env
from grind_env.errors import GrindError

INTRODUCTION = """\
# Errors

A mistake of a user raises a subclass of `GrindError`: one sentence says what is wrong, where, and what to do. The
command line prints this sentence and ends with exit status 2. Every other exception is a bug of the package.

```{eval-rst}
.. automodule:: grind_env.errors
```

The errors below belong to modules without a page. All other errors are on the page of their module.
"""
DIRECTIVE = "\n```{{eval-rst}}\n.. autoexception:: {}.{}\n   :no-members:\n```\n"


def errors_page(docs: Path) -> str:
    """Return the Markdown page: all subclasses in modules that no page of `docs` documents."""
    for module in pkgutil.walk_packages(grind_env.__path__, "grind_env."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
    texts = "".join(path.read_text(encoding="utf-8") for path in docs.glob("*/*.md"))
    known = {"grind_env.errors", *re.findall(r"automodule:: (\S+)", texts)}
    kinds = sorted({(kind.__module__, kind.__name__) for kind in _below(GrindError)})
    own = [(module, name) for module, name in kinds if module.startswith("grind_env.")]
    exported = {name for module in known for name in getattr(import_module(module), "__all__", ())}
    return INTRODUCTION + "".join(
        DIRECTIVE.format(module, name) for module, name in own if module not in known and name not in exported
    )


def _below(kind: type[GrindError]) -> Iterator[type[GrindError]]:
    for each in kind.__subclasses__():
        yield each
        yield from _below(each)
