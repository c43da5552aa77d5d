"""Machines by name: a family and a seed, a mix, the held-out set, or the user's own."""

import re
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from typing import Any

from grind_env.kernel.random import WORD
from grind_env.message_text import did_you_mean, quoted, reason
from grind_env.plants.bursts import BURSTS
from grind_env.plants.drift import DRIFT
from grind_env.plants.family import HELD_OUT, PUBLIC, Family, share_of
from grind_env.plants.fluid import FLUID
from grind_env.plants.foreign import FOREIGN
from grind_env.plants.graded import GRADED
from grind_env.plants.meter import METER
from grind_env.plants.plant import Plant, PlantError, mixed
from grind_env.plants.soft import SOFT
from grind_env.plants.table import TABLE
from grind_env.plants.textbook import TEXTBOOK
from grind_env.plants.thermal import THERMAL

#: families of the sets `public` and `held-out`, in their order in a mix: process wrappers first. Frozen
PUBLIC_FAMILIES: tuple[Family, ...] = (FOREIGN, BURSTS, THERMAL, METER, TABLE, GRADED, FLUID, SOFT, DRIFT)
FAMILIES = (*PUBLIC_FAMILIES, TEXTBOOK)
TRAINING = "training"  #: set of machines that are drawn as in `public` or as in `laws`, with probability 1/2 each
#: stream of random numbers of each set of mixes
SETS = {"held-out": HELD_OUT, "public": PUBLIC, "held-out-laws": HELD_OUT, "laws": PUBLIC, TRAINING: PUBLIC}
MODEL = Plant(name="model")  #: the machine that equals the model
FEWEST, MOST = 2, 4  #: smallest and largest number of families in a machine of a set
FORMS = "'meter:7', a mix as 'foreign:3+meter:7', 'held-out:5', 'laws:5', or 'module:name' for one's own"

_PART = re.compile(r"(?P<name>[\w.-]+)(?::(?P<seed>\d+))?")
_OWN = re.compile(r"(?P<module>[A-Za-z_][\w.]*):(?P<name>[A-Za-z_]\w*)(?::(?P<seed>\d+))?")


@dataclass(frozen=True, slots=True)
class Plants:
    """Machines of one name, which may be a family or a set without a seed.

    All of these machines share process and gauge.
    """

    text: str  #: the name
    first: Plant  #: machine of the name, with seed 0 if the name has no seed
    modules: bool = False  #: whether the name may refer to a module, as for `find_plant`

    def __reduce__(self) -> Any:
        """Pickle by name, because no copy holds the process functions."""
        return partial(find_plants, modules=self.modules), (self.text,)

    @property
    def one(self) -> bool:
        """Return whether there is only one machine."""
        return self.text == self.first.name

    def seeded(self, seed: int) -> "Plants":
        """Return the machine with this 32-bit seed; a name with a seed keeps its own."""
        if self.one:
            return self
        plant = find_plant(self.text, seed=seed, modules=self.modules)
        return Plants(plant.name, plant, self.modules)


def find_plants(text: str, *, modules: bool = False) -> Plants:
    """Return the machines of a name, which may lack a seed, for example `meter` or `held-out`.

    Raises:
        PlantError: no machine has this name.
    """
    first = find_plant(text, seed=0, modules=modules)
    others = find_plant(text, seed=1, modules=modules)
    return Plants(first.name if first == others else text, first, modules)


def find_plant(text: str, *, seed: int | None = None, modules: bool = False) -> Plant:
    """Return the machine of a name; a name always gives the same machine.

    `family:seed` is a member of a family, `a:1+b:2` a mix. `held-out:seed` is reserved for judging: two to four
    families with numbers from a separate random stream. `public:seed` is drawn alike from another stream, for training
    and tuning. All machines of both sets have the same process. `module:name` is a `Plant` in an importable module, and
    `module:name:seed` a member of a `Family` there, alone or in a mix. `model` is the model itself.

    Args:
        text: the name.
        seed: seed for a name without one; None if the name must have one.
        modules: whether the name may refer to a module, whose code is then run; False for names from untrusted files.

    Raises:
        PlantError: no machine has this name; the message lists the names that exist.
    """
    if not isinstance(text, str):
        raise PlantError(f"a machine is named by a text, but not by {quoted(text)}: name {FORMS}")
    if text == MODEL.name:
        return MODEL
    names = text.split("+")
    if len(names) == 1:
        if (part := _part(text, seed)) and part[0] in SETS:
            return _of_set(part[0], _seed(part[1], text))
        if (own := _own_part(text)) and own["seed"] is None:
            found = _imported(own["module"], own["name"], text, modules)
            if isinstance(found, Plant):
                return replace(found, name=text)
            if seed is None:
                raise PlantError(f"{quoted(text)} is a family of machines: give a seed, as '{text}:1'")
    return _mix_members(sorted((_member(name, text, seed, modules) for name in names), key=_order))


def modules_of(text: str) -> list[str]:
    """Return the names of the modules in the name of a machine."""
    return [own["module"] for name in text.split("+") if (own := _own_part(name))]


def _mix_members(members: list[tuple[str, Family, int]]) -> Plant:
    """Return the machine that mixes some members: names, families and seeds, in the order of a mix."""
    families = tuple(family for _, family, _ in members)
    named = [family.name for family in families]
    twice = next((name for number, name in enumerate(named) if name in named[:number]), None)
    if twice is not None:
        raise PlantError(f"a mix has one machine of a family, but two of {quoted(twice)}: leave one of them out")
    replacing = [family.name for family in families if family.wraps is not None]
    if len(replacing) > 1:
        raise PlantError(f"{' and '.join(replacing)} each say what grinds, and a mix has one of these: leave one out")
    numbers = {field: x for _, family, seed in members for field, x in family.drawn(seed).items()}
    return mixed("+".join(f"{name}:{seed}" for name, _, seed in members), families, numbers)


def _order(member: tuple[str, Family, int]) -> tuple[int, str]:
    _, family, _ = member
    return (FAMILIES.index(family) if family in FAMILIES else len(FAMILIES)), family.name


def _member(name: str, text: str, seed: int | None, modules: bool) -> tuple[str, Family, int]:
    """Return the family name, the family and the seed of one part of a mix."""
    known = {each.name: each for each in FAMILIES}
    if part := _part(name, seed):
        family, digits = part
        if family in known:
            return family, known[family], _seed(digits, text)
        if family in SETS:
            which = family.replace("-", " ")
            raise PlantError(f"{quoted(text)} mixes a machine that is {which}, which is a mix already: name it alone")
    elif own := _own_part(name):
        found = _imported(own["module"], own["name"], text, modules)
        digits = own["seed"] or ("" if seed is None else str(seed))
        if not isinstance(found, Family) or not digits:
            raise PlantError(f"{quoted(name)} is no member of a family: a Plant has no seed, and stands in no mix")
        return f"{own['module']}:{own['name']}", found, _seed(digits, text)
    like = did_you_mean(name.partition(":")[0], known)
    raise PlantError(f"there is no machine {quoted(text)}{like}: name {FORMS}; the families are {', '.join(known)}")


def _part(name: str, seed: int | None) -> tuple[str, str] | None:
    """Return the name and the seed digits of a member of a family or set, or None if `name` has another form."""
    found = _PART.fullmatch(name)
    if found is None or (found["seed"] is None and seed is None):
        return None
    return found["name"], found["seed"] or str(seed)


def _own_part(name: str) -> re.Match[str] | None:
    """Return the match of a user's `module:name`, or None if `name` has another form or names a family."""
    found = _OWN.fullmatch(name)
    return found if found and found["module"] not in [each.name for each in FAMILIES] else None


def _seed(digits: str, text: str) -> int:
    """Return a seed of 32 bits."""
    if len(digits) > len(str(WORD)) or int(digits) > WORD:
        raise PlantError(f"the seed in {quoted(text)} is too large: give one from 0 to {WORD}")
    return int(digits)


def _of_set(name: str, seed: int) -> Plant:
    """Return a machine of a set, with the process of all families of the set; families not drawn stay neutral."""
    stream, kind = SETS[name], name
    if name == TRAINING:
        kind = "public" if share_of(seed, stream, name) < 0.5 else "laws"
    count = FEWEST + int((MOST + 1 - FEWEST) * share_of(seed, stream, kind))
    drawn = [TEXTBOOK] if kind.endswith("laws") else []
    for family in sorted(PUBLIC_FAMILIES, key=lambda each: share_of(seed, stream, each.name)):
        replaced = family.wraps is not None and any(each.wraps is not None for each in drawn)
        if len(drawn) < count and not replaced:
            drawn.append(family)
    numbers = {field: x for family in drawn for field, x in family.drawn(seed, stream).items()}
    return mixed(f"{name}:{seed}", PUBLIC_FAMILIES if name in ("public", "held-out") else FAMILIES, numbers)


def _imported(module: str, name: str, text: str, allowed: bool) -> Plant | Family:
    """Return the `Plant` or `Family` of a name in a module."""
    if not allowed:
        raise PlantError(
            f"{quoted(text)} would run the code of a module, which a name in a file must not: give it as an argument"
        )
    try:
        found = getattr(import_module(module), name)
    except (Exception, SystemExit) as error:  # the module's code may raise anything
        raise PlantError(f"{quoted(text)} names no machine ({reason(error)}): name {FORMS}") from None
    if not isinstance(found, Plant | Family):
        raise PlantError(
            f"{quoted(text)} is of type {type(found).__name__}: name a Plant or a Family of grind_env.plants"
        )
    return found
