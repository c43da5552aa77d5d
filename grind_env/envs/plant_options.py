"""Out-of-model machines (`grind_env.plants`) as arguments and reset options of environments."""

from typing import TYPE_CHECKING, Any

import numpy as np

from grind_env.errors import GrindError
from grind_env.kernel.random import WORD
from grind_env.message_text import quoted

if TYPE_CHECKING:
    from grind_env.plants import Plants


class OtherMachine(GrindError):
    """A machine that an environment was not made for."""


def plants_of(argument: Any, of_file: str = "") -> "Plants | None":
    """Return the machines named by an argument, which may name a module, or else the machines named by a file."""
    if argument is None and not of_file:
        return None
    from grind_env.plants import find_plants

    return find_plants(of_file) if argument is None else find_plants(argument, modules=True)


def read_plant_option(value: Any, made: "Plants | None") -> "Plants | None":
    """Return the machines named by a reset option; None for the machines of the environment."""
    found = plants_of(value)
    if found is None:
        return None
    if made is None:
        raise OtherMachine(
            f"plant is {quoted(found.text)}, but the environment was made without one: make it with plant={value!r}"
        )
    if (found.first.process, found.first.gauge) != (made.first.process, made.first.gauge):
        raise OtherMachine(
            f"plant is {quoted(found.text)}, which grinds or shows otherwise than {quoted(made.text)}, with which the"
            " environment was made: name one of the same families, or make an environment with it"
        )
    return found


def seed_beside(rng: np.random.Generator) -> int:
    """Return a seed of 32 bits from another stream than that of a generator, which does not advance.

    So stocks, lots and noise of an episode do not depend on the machine.
    """
    bits: Any = rng.bit_generator
    return int(np.random.Generator(bits.jumped()).integers(WORD, endpoint=True))
