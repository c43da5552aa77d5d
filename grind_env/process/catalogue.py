"""The catalogue: built-in entries and the user's own, read from TOML files.

A file holds tables `[material.NAME]`, `[wheel.NAME]`, `[dresser.NAME]`, `[fluid.NAME]` and
`[machine.NAME]`. Their keys are the fields of the class of that name in `entries.py`. A table gives every
field, or names as `base` an entry of its own kind that supplies the rest::

    [material.hard_52100_lot]       # a new material: 52100 that dulls the wheel twice as fast
    base = "aisi_52100"
    wear_flat_growth = 2.5e-6

    [machine.default]               # the default machine with a stiffer loop
    base = "default"
    stiffness = 50_000

A calibrated file has its uncertainty in a table `[uncertainty]`; the table of the last such file holds.

`aliases`, a list of texts, are other names of an entry; case, blanks and signs do not matter.

A table with an existing name redefines the entry. `base` means the definition at that point: from an earlier table, an
earlier file, or the built-in one.
"""

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

from grind_env.files import ReadError, shown
from grind_env.message_text import did_you_mean, listed, quoted, shortened
from grind_env.process.entries import CatalogueError, Dresser, Entry, Fluid, Machine, Material, Wheel, label, quantities
from grind_env.process.toml_tables import keys
from grind_env.toml import TomlError, read_toml

BUILT_IN = Path(__file__).with_name("catalogue_data")

KINDS: Mapping[str, type[Entry]] = {
    "material": Material,
    "wheel": Wheel,
    "dresser": Dresser,
    "fluid": Fluid,
    "machine": Machine,
}

#: the entry of each kind for a set-up that names none
USUAL = {"wheel": "a60j", "dresser": "single_point", "fluid": "emulsion", "machine": "default"}

EntryT = TypeVar("EntryT", bound=Entry)
Entries = Mapping[tuple[str, str], Entry]  #: entries by kind (a key of `KINDS`) and name


RENAMED = {"force_ratio": "normal_force_ratio"}  #: old names of keys, with the new ones

UNCERTAINTY = "uncertainty"  #: heading of the table with the uncertainty of a calibration


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibrated:
    """A calibrated file."""

    table: Mapping[str, Any]  #: content of its table `[uncertainty]`
    names: Mapping[str, tuple[str, ...]]  #: names of its entries, by kind
    file: str  #: name of the file; empty for a document


@dataclass(frozen=True, slots=True, kw_only=True)
class Catalogue:
    """All known entries by name, and the last calibrated file among those read, if there is one."""

    materials: Mapping[str, Material]
    wheels: Mapping[str, Wheel]
    dressers: Mapping[str, Dresser]
    fluids: Mapping[str, Fluid]
    machines: Mapping[str, Machine]
    calibrated: Calibrated | None = None

    def material(self, name: str) -> Material:
        """Return the material of that name; CatalogueError if there is none, as for the other kinds."""
        return _find(Material, name, self.materials)

    def wheel(self, name: str) -> Wheel:
        """Return the wheel of that name."""
        return _find(Wheel, name, self.wheels)

    def dresser(self, name: str) -> Dresser:
        """Return the dresser of that name."""
        return _find(Dresser, name, self.dressers)

    def fluid(self, name: str) -> Fluid:
        """Return the fluid of that name."""
        return _find(Fluid, name, self.fluids)

    def machine(self, name: str) -> Machine:
        """Return the machine of that name."""
        return _find(Machine, name, self.machines)


def load_catalogue(*paths: str | PathLike[str], document: Mapping[str, Any] = MappingProxyType({})) -> Catalogue:
    """Return the built-in entries with those of the files, in order; later entries redefine earlier ones.

    Args:
        paths: the files.
        document: tables as in a file, read after the files.

    Raises:
        CatalogueError: A file cannot be read or is not TOML, or one of its entries is not usable; the message
            names file, entry, key, value and legal range.

    Example:
        >>> from grind_env.process.catalogue import load_catalogue
        >>> wheel = load_catalogue().wheel("a60j")
        >>> wheel.diameter, wheel.width  # mm
        (300.0, 25.0)
    """
    entries, calibrated = dict(_built_in()), None
    for path in paths:
        content = _content(Path(path))
        entries |= _of_file(Path(path), content, entries)
        calibrated = _calibrated(content, str(path)) or calibrated
    entries |= _entries(document, entries)
    return Catalogue(
        materials=_of_kind(Material, entries),
        wheels=_of_kind(Wheel, entries),
        dressers=_of_kind(Dresser, entries),
        fluids=_of_kind(Fluid, entries),
        machines=_of_kind(Machine, entries),
        calibrated=_calibrated(document, "") or calibrated,
    )


def is_calibrated(path: Path) -> bool:
    """Return whether a catalogue file has the uncertainty of a calibration.

    Raises:
        CatalogueError: the file cannot be read or is not TOML.
    """
    return UNCERTAINTY in _content(path)


@functools.cache
def _built_in() -> Entries:
    entries: dict[tuple[str, str], Entry] = {}
    for path in sorted(BUILT_IN.glob("*.toml")):
        entries |= _of_file(path, _content(path), entries)
    return MappingProxyType(entries)


def _content(path: Path) -> Mapping[str, Any]:
    try:
        return read_toml(path)
    except ReadError as error:
        raise CatalogueError(f"{shown(path)}: the catalogue cannot be read: {error.reason}.") from None
    except TomlError as error:
        raise CatalogueError(f"{shown(path)}: the catalogue is not valid TOML: {error}.") from None


def _of_file(path: Path, document: Mapping[str, Any], known: Entries) -> Entries:
    try:
        return _entries(document, known)
    except CatalogueError as error:
        raise CatalogueError(f"{shown(path)}: {error}") from None


def _calibrated(document: Mapping[str, Any], file: str) -> Calibrated | None:
    if UNCERTAINTY not in document:
        return None
    names = {kind: tuple(tables) for kind, tables in document.items() if kind in KINDS}
    return Calibrated(table=document[UNCERTAINTY], names=names, file=file)


def _entries(document: Mapping[str, Any], known: Entries) -> Entries:
    entries = dict(known)
    for heading, tables in document.items():
        if heading == UNCERTAINTY:
            _table(tables, heading)
            continue
        if heading not in KINDS:
            raise CatalogueError(
                f"there is no kind of entry {quoted(heading)}{did_you_mean(heading.lower(), KINDS)}; "
                f"tables are headed [KIND.NAME], KIND being one of {', '.join(KINDS)}."
            )
        kind = KINDS[heading]
        for name, table in _table(tables, heading).items():
            values = _table(table, label(kind, name))
            entries[heading, name] = _entry(kind, name, values, _of_kind(kind, entries))
    return entries


def _table(value: object, place: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise CatalogueError(f"{place}: found {quoted(value)} where a table headed [KIND.NAME] belongs.")
    return value


def _entry(kind: type[EntryT], name: str, table: Mapping[str, Any], known: Mapping[str, EntryT]) -> EntryT:
    place, legal = label(kind, name), quantities(kind)
    for key, value in table.items():
        if RENAMED.get(key) in legal:
            raise CatalogueError(f"{place}: {key} was renamed to {RENAMED[key]}, normal over tangential force.")
        if key not in ("base", "aliases", *legal):
            raise CatalogueError(
                f"{place}: there is no key {shortened(key)} (= {quoted(value)}){did_you_mean(key.lower(), legal)}; "
                f"the keys are base, aliases, {', '.join(legal)}."
            )
    values = dict(table)
    if "base" in values:
        try:
            base = _find(kind, values.pop("base"), known)
        except CatalogueError as error:
            raise CatalogueError(f"{place}: base: {error}") from None
        own = {"aliases": base.aliases} if base.name == name else {}  # the aliases of another entry are not inherited
        values = own | {key: getattr(base, key) for key in legal} | values
    missing = [f"{key} ({legal[key]})" for key in keys(kind, required=True) if key not in ("name", *values)]
    if missing:
        raise CatalogueError(f"{place}: add {', '.join(missing)}, or name a base that supplies what is missing.")
    return kind(name=name, **values)


def _of_kind(kind: type[EntryT], entries: Entries) -> dict[str, EntryT]:
    return {entry.name: entry for entry in entries.values() if isinstance(entry, kind)}


def entry_name(name: str, known: Mapping[str, Entry]) -> str:
    """Return the entry name for a name or alias in any spelling; the text itself if unknown."""
    if name in known:
        return name
    meant = _folded(name)
    return next((key for key, entry in known.items() if meant in map(_folded, entry.aliases)), name)


def _folded(name: str) -> str:
    """Return a name in small letters and digits alone: `16 MnCr 5` is `16MnCr5`."""
    return "".join(filter(str.isalnum, name.casefold()))


def _find(kind: type[EntryT], name: object, known: Mapping[str, EntryT]) -> EntryT:
    found = known.get(entry_name(name, known)) if isinstance(name, str) else None
    if found is None:
        text, names = quoted(name).strip("'"), listed(sorted(known))
        aliases = (alias for entry in known.values() for alias in entry.aliases)
        hint = did_you_mean(text.lower(), known) or did_you_mean(text, aliases)
        raise CatalogueError(f"there is no {label(kind, name)}{hint}; known are {names}.")
    return found
