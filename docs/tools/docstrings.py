"""Sphinx extension: adapt the docstrings of the package to Sphinx.

Long docstrings have Markdown headings. Texts of attributes may contain colons, which napoleon takes for a type. Units
and ranges of fields are in their annotations; the extension moves them from the signature into the text.
"""

import re
from dataclasses import fields, is_dataclass
from typing import Annotated, Any, get_args, get_origin

from sphinx.application import Sphinx

from grind_env.process.entries import Choice, Quantity

COLON = "\ue000"  #: replacement of a colon while napoleon reads
BEFORE_NAPOLEON, AFTER_NAPOLEON = 100, 900
ANNOTATED = re.compile(r"~?(?:typing|types)?\.?Annotated\[(.+?), ~?[\w.]*?(?:Quantity|Choice)\(.*?\)\]")
#: pattern of a process or gauge as default: Sphinx prints its functions and then cannot parse the signature
MADE_OF_FUNCTIONS = re.compile(r"((?:Process|Gauge) = )\(.+?\)(?=, \w+: )")
FIELD = re.compile(r"^:ivar (\w+): ")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the changes of docstrings and signatures."""
    app.connect("autodoc-process-docstring", _hide_colons, BEFORE_NAPOLEON)
    app.connect("autodoc-process-docstring", _show_colons, AFTER_NAPOLEON)
    app.connect("autodoc-process-docstring", _say_units, AFTER_NAPOLEON)
    app.connect("autodoc-process-signature", _plain_signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _hide_colons(_app: Sphinx, what: str, _name: str, _value: Any, _options: Any, lines: list[str]) -> None:
    if what in ("attribute", "data", "property"):
        lines[:] = [line.replace(":", COLON) for line in lines]
    lines[:] = [re.sub(r"^#+ (.+)$", r".. rubric:: \1", line) for line in lines]


def _show_colons(_app: Sphinx, _what: str, _name: str, _value: Any, _options: Any, lines: list[str]) -> None:
    lines[:] = [line.replace(COLON, ":") for line in lines]


def _say_units(_app: Sphinx, what: str, _name: str, value: Any, _options: Any, lines: list[str]) -> None:
    """Put range and unit before the text of every field that has them."""
    if what == "class" and is_dataclass(value):
        legal = {field.name: _legal(field.type) for field in fields(value)}
        for place, line in enumerate(lines):
            match = FIELD.match(line)
            if match and legal.get(match[1]):
                lines[place] = f"{match[0]}*{legal[match[1]]}*; {line[match.end() :]}"


def _legal(hint: Any) -> str:
    held = get_args(hint)[1:] if get_origin(hint) is Annotated else ()
    return next((str(each) for each in held if isinstance(each, Quantity | Choice)), "")


def _plain_signature(
    _app: Sphinx, _what: str, _name: str, _value: Any, _options: Any, signature: str | None, returns: str | None
) -> tuple[str | None, str | None] | None:
    if not signature:
        return None
    signature = ANNOTATED.sub(r"\1", signature).replace("<factory>", "...")
    return MADE_OF_FUNCTIONS.sub(r"\1...", signature), returns
