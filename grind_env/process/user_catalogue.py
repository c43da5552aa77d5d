"""A user's catalogue: its files, and the overrides of a set-up.

Jobs and tasks have both: `[catalogue] files = ["shop.toml"]`, and `[setup] wheel_overrides = { width = 65.0 }`. A job
may have entries of its own, too, in tables such as `[catalogue.wheel.NAME]`.
"""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from grind_env.process.catalogue import KINDS, UNCERTAINTY, Catalogue, is_calibrated, load_catalogue
from grind_env.process.entries import CatalogueError, quantities
from grind_env.process.toml_tables import Error, TomlTable, sub_table, wrong

OWN = *KINDS, UNCERTAINTY  #: tables that a job may have in its own catalogue, as a catalogue file
OVERRIDES = tuple(f"{kind}_overrides" for kind in KINDS)  #: keys of a set-up that change single values of an entry


def files_of(document: TomlTable, folder: Path, error: Error, own: Iterable[str] = ()) -> list[Path]:
    """Return the catalogue files that a document names, searched in a folder; `own` keys may stand beside them."""
    files = sub_table(document, "catalogue", ("files", *own), error).get("files", [])
    if not isinstance(files, list) or not all(isinstance(name, str) for name in files):
        raise wrong("catalogue.files", files, "a list of file names", error)
    return [folder / name for name in files]


def catalogue_of(document: TomlTable, folder: Path, error: Error, *, calibrated: bool = True) -> Catalogue:
    """Return the built-in catalogue with the files and entries of a document; calibrated files only if `calibrated`."""
    files = files_of(document, folder, error, OWN)
    entries = {kind: tables for kind, tables in document.get("catalogue", {}).items() if kind in OWN}
    try:
        if not calibrated:
            files = [path for path in files if not is_calibrated(path)]
        return load_catalogue(*files, document=entries)
    except CatalogueError as reason:
        place = "catalogue.files" if files else "catalogue"
        raise error(f"{place}: {reason}", place, files) from None


def entry_of(catalogue: Catalogue, key: str, name: object, setup: TomlTable, error: Error) -> Any:
    """Return the catalogue entry of a key such as `setup.wheel`, with the overrides of the set-up."""
    kind = key.rpartition(".")[2]
    place = f"setup.{kind}_overrides"
    try:
        entry = getattr(catalogue, kind)(name)
    except CatalogueError as reason:
        raise error(f"{key}: {reason}", key, name) from None
    overrides = sub_table(setup, f"{kind}_overrides", quantities(type(entry)), error, place)
    try:
        return replace(entry, **overrides)
    except CatalogueError as reason:
        raise error(f"{place}: {reason}", place, overrides) from None
