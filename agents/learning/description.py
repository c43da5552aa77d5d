"""The description of a learned agent beside its tensors: JSON of which nothing is taken on trust."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from agents.learning.learned import ACTIVATIONS, FAMILIES, Network
from agents.learning.view import Actions, Memory
from grind_env.errors import GrindError, quoted

FORMAT = 1
MOST_UNITS, MOST_LAYERS = 65_536, 16

NO_AGENT = "holds no agent that `python -m agents train` saved"


class PolicyFileError(GrindError):
    """A file that is not there, holds no agent, or holds one that does not fit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Description:
    """What is written beside the tensors."""

    task: str
    kind: str
    memory: Memory
    actions: Actions
    network: Network
    spaces: str
    """`spaces_digest` of the view that it was trained with."""


def read_description(path: Path, text: str | None) -> Description:
    """The description in the metadata of a file.

    Args:
        path: the file, for messages.
        text: JSON; None for a file without.

    Raises:
        PolicyFileError: if it is none.
    """
    if text is None:
        raise PolicyFileError(f"{path} {NO_AGENT}: it has no description")
    try:
        document = json.loads(text)
        if type(document["format"]) is not int or document["format"] != FORMAT:
            raise PolicyFileError(f"{path} has format {quoted(document['format'])}, but this version reads {FORMAT}")
        network = document["network"]
        return Description(
            task=_word(document["task"]),
            kind=_word(document["kind"]),
            memory=_one_of(get_args(Memory), document["memory"]),
            actions=_one_of(get_args(Actions), document["actions"]),
            network=Network(
                family=_one_of(tuple(FAMILIES), network["family"]),
                entries=_units(network["entries"]),
                lstm=_units(network["lstm"], least=0),
                hidden=tuple(_units(each) for each in _listed(network["hidden"])),
                outputs=_units(network["outputs"]),
                activation=_one_of(tuple(ACTIVATIONS), network["activation"]),
            ),
            spaces=_word(document["spaces"]),
        )
    except PolicyFileError:
        raise
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise PolicyFileError(f"{path} {NO_AGENT}: its description is damaged ({error!r:.80})") from None


def _word(value: Any) -> str:
    """A name without spaces or control characters, which a terminal would obey."""
    if not isinstance(value, str) or not (value.isascii() and value.replace("_", "a").isalnum()):
        raise TypeError(f"{value!r:.20} is no name")
    return value


def _one_of(legal: tuple[Any, ...], value: Any) -> Any:
    if not isinstance(value, str) or value not in legal:
        raise ValueError(f"{value!r:.20} is none of {', '.join(legal)}")
    return value


def _units(value: Any, least: int = 1) -> int:
    if type(value) is not int or not least <= value <= MOST_UNITS:
        raise ValueError(f"{value!r:.20} is no number of units")
    return value


def _listed(value: Any) -> list[Any]:
    if not isinstance(value, list) or len(value) > MOST_LAYERS:
        raise TypeError(f"{value!r:.20} is no list of layers")
    return value
