"""Learned agents on disk: tensors and a description, in one `.safetensors` file that runs no code when it is read.

Stable-Baselines3 saves pickles, and a pickle does whatever its author wrote into it. A stranger's file is read here as
numbers and JSON only: the description names one of a few known networks, every tensor must have the shape that follows
from it, and whatever does not fit is refused with one sentence.
"""

import hashlib
import json
import zipfile
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, get_args

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from agents.learning.description import FORMAT, NO_AGENT, PolicyFileError, read_description
from agents.learning.learned import ACTIVATIONS, FAMILIES, LSTM, Actor, LearnedPolicy, Network, Tensor, outputs_of
from agents.learning.settings import Settings
from agents.learning.view import FEATURE_BOUND, Actions, LearnerView, Memory
from agents.provenance import commit, installed
from grind_env.envs.observations import readings
from grind_env.envs.tasks import Task, load_task
from grind_env.errors import reason
from grind_env.files import MOST_BYTES, write_atomically

Sizes = NDArray[np.float64]

SUFFIX = ".safetensors"
ENTRY = "grind_policy"
"""Entry of the file's metadata that holds the description."""

MOST_SUM = 0.5 * float(np.finfo(np.float32).max)
"""What a unit may add up to at most; half of what float32 holds, because sums in float32 are rounded."""
PACKAGES = ("grind_env", "numpy", "stable_baselines3", "sb3_contrib", "torch")

POLICIES: Mapping[str, str] = {
    "ActorCriticPolicy": "actor_critic",
    "RecurrentActorCriticPolicy": "recurrent_actor_critic",
    "DQNPolicy": "q_network",
    "SACPolicy": "squashed_actor",
    "TQCPolicy": "squashed_actor",
}
"""Family of each policy class of Stable-Baselines3 and sb3-contrib that is trained here."""


def save_policy(path: Path, model: Any, task: Task, kind: str, settings: Settings) -> None:
    """Write what acting needs of a trained model, whole or not at all; its folder is made.

    Args:
        path: a .safetensors file.
        model: an algorithm of Stable-Baselines3 or sb3-contrib.
        task: what it was trained on.
        kind: name of the kind of agent.
        settings: that it was trained with.

    Raises:
        PolicyFileError: if its policy is of no known family, or its weights are not finite or too large.
    """
    policy = model.policy
    state = {name: values.detach().cpu().numpy() for name, values in policy.state_dict().items()}
    actor = acting_part(type(policy).__name__, state, policy.activation_fn.__name__.lower())
    _check_finite(path, actor.tensors)
    network = actor.network
    _check_sums(path, network, actor.tensors)
    document = {
        "format": FORMAT,
        "task": task.name,
        "kind": kind,
        "memory": settings.memory,
        "actions": settings.actions,
        "network": {each.name: getattr(network, each.name) for each in fields(network)},
        "spaces": spaces_digest(LearnerView(task, settings.memory, settings.actions)),
        "settings": {each.name: _plain(getattr(settings, each.name)) for each in fields(settings)},
        "versions": {package: installed(package) for package in PACKAGES},
        "commit": commit(),
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    data = save(actor.tensors, {ENTRY: json.dumps(document)})
    write_atomically(path, lambda partial: partial.write_bytes(data))


def load_policy(path: Path, *, task: Task | None = None, trust: bool = False, name: str | None = None) -> LearnedPolicy:
    """The agent in a file.

    Args:
        path: file that `save_policy` wrote.
        task: what it must have been trained for; by default whatever the file says.
        trust: load a `.zip` of Stable-Baselines3, too, which can run code of its author; it needs `task`.
        name: name in tables; by default the kind of agent.

    Raises:
        PolicyFileError: if there is no such file, or it holds no agent, or not one for the task.
    """
    if not path.is_file():
        raise PolicyFileError(f"there is no trained agent at {path}: run `python -m agents train` first")
    if path.stat().st_size > MOST_BYTES:
        raise PolicyFileError(f"{path} has more than {MOST_BYTES / 1e6:g} MB: it {NO_AGENT}")
    with path.open("rb") as opened:
        begins = opened.read(2)
    # a safetensors file may end like a zip file, but does not begin like one
    if begins == b"PK" and zipfile.is_zipfile(path):
        if not trust:
            raise PolicyFileError(
                f"{path} is a .zip, and loading a model of Stable-Baselines3 can run code of its author:"
                " give a .safetensors file, or --trust if you know who made it"
            )
        return _load_zip(path, task, name or path.stem)
    try:
        with safe_open(path, "numpy") as file:
            described = read_description(path, (file.metadata() or {}).get(ENTRY))
            found = {key: _stored(file.get_slice(key)) for key in sorted(file.keys())}
            wanted = {key: ("F32", shape) for key, shape in described.network.shapes().items()}
            if found != wanted:
                raise PolicyFileError(f"{path}: its tensors are not those of the network that it describes")
            tensors = {key: file.get_tensor(key) for key in wanted}
    except (SafetensorError, OSError) as error:
        raise PolicyFileError(f"{path} {NO_AGENT} ({reason(error)}): train one anew") from None
    _check_finite(path, tensors)
    trained_for = load_task(described.task)
    if task is not None and task.name != trained_for.name:
        raise PolicyFileError(f"{path} was trained for {trained_for.name}, not for {task.name}")
    view = LearnerView(trained_for, described.memory, described.actions)
    if described.spaces != spaces_digest(view) or not _fits(described.network, view):
        raise PolicyFileError(
            f"{path} was trained for another version of {trained_for.name}, with other observations or actions:"
            " train one anew"
        )
    _check_sums(path, described.network, tensors)
    return LearnedPolicy(
        Actor(described.network, tensors),
        trained_for.name,
        described.memory,
        described.actions,
        name or described.kind,
    )


def spaces_digest(view: LearnerView) -> str:
    """Hash of what a learner sees of a task and how it acts; equal digests mean the same numbers mean the same."""
    entries = [[*entry] for entry in readings(view.task, full=False)]
    seen = [entries, view.observation_space.shape[0], str(view.action_space), view.codec.levels.tolist()]
    bounds = [view.codec.low, view.codec.high, view.codec.executions]
    return hashlib.sha256(json.dumps([seen, bounds]).encode()).hexdigest()


def acting_part(policy_class: str, state: Mapping[str, Tensor], activation: str) -> Actor:
    """What acting needs of the state of a policy of Stable-Baselines3: the actor without critics.

    Args:
        policy_class: name of its class.
        state: its tensors by name.
        activation: name of its activation.

    Raises:
        PolicyFileError: if the class or the activation is not known, or the network is another one.
    """
    if policy_class not in POLICIES or activation not in ACTIVATIONS:
        raise PolicyFileError(f"a {policy_class} with {activation} cannot be saved: only {', '.join(POLICIES)} can")
    family = POLICIES[policy_class]
    layers = FAMILIES[family]
    lstm = state[f"{LSTM}.weight_hh_l0"].shape[1] if layers.recurrent else 0
    hidden: list[int] = []
    while f"{layers.body.format(2 * len(hidden))}.weight" in state:
        hidden.append(len(state[f"{layers.body.format(2 * len(hidden))}.weight"]))
    if layers.head == layers.body:
        hidden.pop()
    names = Network(family=family, entries=1, lstm=lstm, hidden=tuple(hidden), outputs=1, activation=activation)
    head = f"{names.linear()[-1]}.weight"
    first = f"{LSTM}.weight_ih_l0" if lstm else f"{names.linear()[0]}.weight"
    network = Network(
        family=family,
        entries=state[first].shape[1],
        lstm=lstm,
        hidden=tuple(hidden),
        outputs=len(state[head]),
        activation=activation,
    )
    actor_shapes = network.shapes()
    if any(key not in state or state[key].shape != shape for key, shape in actor_shapes.items()):
        raise PolicyFileError(f"the network of this {policy_class} has layers that cannot be saved")
    return Actor(network, {key: state[key] for key in actor_shapes})


def _load_zip(path: Path, task: Task | None, name: str) -> LearnedPolicy:
    """The agent in a trusted .zip of Stable-Baselines3; memory and actions are those that fit its network."""
    from stable_baselines3.common.save_util import load_from_zip_file

    if task is None:
        raise PolicyFileError(f"{path} does not say what it was trained for: name the task")
    try:
        loaded: Any = load_from_zip_file(path, device="cpu")
        data, parameters, _ = loaded
        policy_class = data["policy_class"].__name__
        default = "tanh" if "ActorCritic" in policy_class else "relu"
        chosen = data["policy_kwargs"].get("activation_fn")
        activation = default if chosen is None else chosen.__name__.lower()
        actor = acting_part(policy_class, {key: each.numpy() for key, each in parameters["policy"].items()}, activation)
    except Exception as error:
        # a pickle runs whatever its author wrote, which may raise anything; PyTorch goes on to advise more trust
        said = reason(error).partition(". ")[0]
        raise PolicyFileError(f"{path} holds no model of Stable-Baselines3 ({said})") from None
    for memory in get_args(Memory):
        for actions in get_args(Actions):
            if _fits(actor.network, LearnerView(task, memory, actions)):
                _check_sums(path, actor.network, actor.tensors)
                return LearnedPolicy(actor, task.name, memory, actions, name)
    raise PolicyFileError(f"{path} was not trained for {task.name}: its observations or actions differ")


def _fits(network: Network, view: LearnerView) -> bool:
    """Whether a network reads the features of a view and says its actions."""
    squashed, valued = FAMILIES[network.family].squashed, network.family == "q_network"
    acts = not squashed or isinstance(view.action_space, spaces.Box)
    chooses = not valued or isinstance(view.action_space, spaces.Discrete)
    sizes = (network.entries, network.outputs) == (view.observation_space.shape[0], outputs_of(view.action_space))
    return acts and chooses and sizes


def _stored(stored: Any) -> tuple[str, tuple[int, ...]]:
    """Type and shape of a stored tensor."""
    return stored.get_dtype(), tuple(stored.get_shape())


def _check_finite(path: Path, tensors: Mapping[str, Tensor]) -> None:
    """Check the weights.

    Raises:
        PolicyFileError: if one is NaN or infinite.
    """
    for name, values in tensors.items():
        if not np.isfinite(values).all():
            raise PolicyFileError(f"{path}: {name} has a weight that is no finite number")


def _check_sums(path: Path, network: Network, tensors: Mapping[str, Tensor]) -> None:
    """Check that no features make a unit overflow: of outputs that are NaN the first would be chosen without a word.

    Raises:
        PolicyFileError: if a unit may add up to more than `MOST_SUM`, or a weight is NaN or infinite.
    """

    def sums(layer: str, largest: Sizes, suffix: str = "") -> Sizes:
        """The largest sizes of the sums of a layer, shape (units,), from those of what it reads."""
        weight, bias = (np.abs(tensors[f"{layer}.{part}{suffix}"].astype(np.float64)) for part in ("weight", "bias"))
        found: Sizes = weight @ largest + bias
        return found

    def check(layer: str, largest: Sizes) -> None:
        # NaN is not below anything either
        if not (largest <= MOST_SUM).all():
            raise PolicyFileError(f"{path}: the weights of {layer} are so large that it may overflow: train one anew")

    largest = np.full(network.entries, FEATURE_BOUND)
    if network.lstm:
        # what it shows lies between -1 and 1
        shown = np.ones(network.lstm)
        check(LSTM, sums(LSTM, largest, "_ih_l0") + sums(LSTM, shown, "_hh_l0"))
        largest = shown
    for layer in network.linear():
        largest = sums(layer, largest)
        check(layer, largest)
        if network.activation == "tanh":
            largest = np.minimum(largest, 1.0)


def _plain(value: Any) -> Any:
    """A setting as JSON has it."""
    return dict(value) if isinstance(value, Mapping) else value
