"""Trained agents on disk: tensors and a description in a `.safetensors` file, which runs no code.

Stable-Baselines3 saves pickles, which can run any code of their author. Here an untrusted file is read as numbers and
JSON only. Its description names a known network, and every tensor must have the shape that follows from
this network. A file that does not fit is refused with an error message.
"""

import hashlib
import json
import zipfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path, PurePath
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from grind_env.dataclass_json import FormError, formed
from grind_env.envs.input_comparison import calibrated, describe_differences, differing, inputs_of
from grind_env.envs.simulation import Simulation
from grind_env.errors import GrindError
from grind_env.files import MOST_BYTES, is_file, shown, write_atomically
from grind_env.message_text import quoted, reason, shortened
from grind_env.policies.learned.agent_spaces import FEATURE_BOUND, LearnerForm, LearnerView, MemoryKind
from grind_env.policies.learned.network import ACTIVATION, FAMILY, GRU, Actor, LearnedPolicy, Network, Tensor
from grind_env.policies.problem_lookup import find_problem
from grind_env.task_version import TASK_VERSION, of_version

Sizes = NDArray[np.float64]

SUFFIX = ".safetensors"
ENTRY = "grind_policy"  #: entry of the file's metadata that holds the description

#: largest sum in a unit: half of the largest float32 number, because sums in float32 are rounded
MOST_SUM = 0.5 * float(np.finfo(np.float32).max)

FORMAT = 1
VERSION = "task_version"  #: entry of the description: the version of the tasks that an agent was trained on
MOST_UNITS, MOST_LAYERS = 65_536, 16

NO_AGENT = "holds no agent that `grind train` saved"


class PolicyFileError(GrindError):
    """Missing file, file without an agent, or agent that does not fit."""


class OtherPart(PolicyFileError):
    """Agent that was trained for another part."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Description:
    """Description saved beside the tensors.

    Raises:
        ValueError: a name contains a folder or control characters, or the network is not of a known form.
    """

    task: str
    kind: str
    memory: MemoryKind
    actions: Literal["grid"]
    network: Network
    spaces: str  #: `spaces_digest` of the view in training
    #: `inputs_of` the training simulation, in the units of job or task; None in files without this entry
    inputs: Mapping[str, str | int | float | bool] | None = None
    machines: str = ""  #: name of the training machines; empty in files without this entry

    def __post_init__(self) -> None:
        network, names = self.network, (self.task, self.kind, self.spaces, self.machines or "-")
        if not all(name and name.isprintable() and PurePath(name).name == name for name in names):
            raise ValueError("it has a name that is none")
        if network.family != FAMILY or network.activation != ACTIVATION:
            raise ValueError("its network is of no known family or activation")
        units = network.entries, network.outputs, *network.hidden, network.lstm or 1
        if len(network.hidden) > MOST_LAYERS or not all(1 <= each <= MOST_UNITS for each in units):
            raise ValueError("its network has no such layers")

    @property
    def form(self) -> LearnerForm:
        """Return the observations and actions of the agent."""
        return LearnerForm(self.memory)


def load_policy(
    path: Path, *, simulation: Simulation | None = None, name: str | None = None, other_part: bool = False
) -> LearnedPolicy:
    """Return the agent in a file.

    Args:
        path: file that `grind train` wrote.
        simulation: simulation for which the agent must have been trained; by default of the task that the file names.
        name: name in tables; by default the kind of agent.
        other_part: accept an agent of another part if its observations and actions fit; its `remark` says so.

    Raises:
        OtherPart: the agent was trained for another part or task.
        PolicyFileError: the file does not exist, or holds no agent for the task.
    """
    if not is_file(path):
        raise PolicyFileError(f"there is no trained agent at {shown(path)}: run `grind train` first")
    if path.stat().st_size > MOST_BYTES:
        raise PolicyFileError(f"{path} has more than {MOST_BYTES / 1e6:g} MB: it {NO_AGENT}")
    with path.open("rb") as opened:
        begins = opened.read(2)
    # a safetensors file may end like a zip file, but does not begin like one
    if begins == b"PK" and zipfile.is_zipfile(path):
        raise PolicyFileError(
            f"{path} is a .zip, and loading a model of Stable-Baselines3 can run code of its author:"
            " give a .safetensors file, or --trust if you know who made it"
        )
    try:
        with safe_open(path, "numpy") as file:
            described = read_description(path, (file.metadata() or {}).get(ENTRY))
            stored = {key: file.get_slice(key) for key in sorted(file.keys())}
            found = {key: (each.get_dtype(), tuple(each.get_shape())) for key, each in stored.items()}
            wanted = {key: ("F32", shape) for key, shape in described.network.shapes().items()}
            if found != wanted:
                raise PolicyFileError(f"{path}: its tensors are not those of the network that it describes")
            tensors = {key: file.get_tensor(key) for key in wanted}
    except (SafetensorError, OSError) as error:
        raise PolicyFileError(f"{path} {NO_AGENT} ({reason(error)}): train one anew") from None
    check_finite(path, tensors)
    if simulation is None:
        simulation = find_problem(described.task).simulation()
    remark, trained_for_other = _remark(path, described, simulation)
    if trained_for_other and not other_part:
        raise OtherPart(f"{remark}: train another agent with `grind train`, or accept this one with --other-part")
    view = described.form.view(simulation)
    # a difference that the remark names may have changed the scales of the observations, too
    sizes = described.network.entries, described.network.outputs
    fits = sizes == (view.observation_space.shape[0], int(view.action_space.nvec.sum()))
    if (described.spaces != spaces_digest(view) and not remark) or not fits:
        raise PolicyFileError(
            f"{path} was trained for another version of {described.task}, with other observations or actions:"
            " train one anew"
        )
    check_sums(path, described.network, tensors)
    return LearnedPolicy(
        Actor(described.network, tensors),
        simulation.task.name,
        described.form,
        name or described.kind,
        described.machines,
        remark,
    )


def _remark(path: Path, described: Description, simulation: Simulation) -> tuple[str, bool]:
    """Return a remark on an agent that was trained for something else, and whether its use needs permission."""
    task, before = simulation.task, described.inputs
    other = "another part" if task.name == described.task else f"{described.task}, not for {task.name}"
    if before is None:
        if task.name == described.task and task.file:
            return f"{path} does not say for what part it was trained", True
        return ("", False) if task.name == described.task else (f"{path} was trained for {other}", True)
    now = inputs_of(simulation)
    names = differing(now, before)
    if not names:
        return "", False
    said = describe_differences(names, now, before)
    if calibrated(simulation, names):
        return f"{path} was trained before the job was calibrated: {said}; train it anew to use that", False
    return f"{path} was trained for {other}: {said}", True


def write_policy(
    path: Path, actor: Actor, simulation: Simulation, kind: str, form: LearnerForm, beside: Mapping[str, Any]
) -> None:
    """Write an agent atomically, and make its folder.

    Args:
        path: a .safetensors file.
        actor: network of the agent.
        simulation: simulation of the training.
        kind: name of the kind of agent.
        form: observations and actions of the agent.
        beside: further facts for the description, such as the training `machines`, as JSON types.

    Raises:
        PolicyFileError: weights are not finite or too large.
    """
    check_finite(path, actor.tensors)
    check_sums(path, actor.network, actor.tensors)
    document = {
        "format": FORMAT,
        VERSION: TASK_VERSION,
        "task": simulation.task.name,
        "kind": kind,
        "memory": form.memory,
        "actions": "grid",
        "network": asdict(actor.network),
        "spaces": spaces_digest(form.view(simulation)),
        "inputs": inputs_of(simulation),
        **beside,
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    data = save(actor.tensors, {ENTRY: json.dumps(document)})
    write_atomically(path, lambda partial: partial.write_bytes(data))


def spaces_digest(view: LearnerView) -> str:
    """Return a hash of a learner's observations and actions; equal hashes mean equal meanings of all numbers."""
    entries = [[*entry] for entry in view.entries]
    seen = [entries, view.observation_space.shape[0], str(view.action_space), view.codec.levels.tolist()]
    bounds = [view.codec.low, view.codec.high, view.codec.executions]
    return hashlib.sha256(json.dumps([seen, bounds]).encode()).hexdigest()


def check_finite(path: Path, tensors: Mapping[str, Tensor]) -> None:
    """Check that all weights are finite, whatever their shapes.

    Raises:
        PolicyFileError: a weight is NaN or infinite.
    """
    for name, values in tensors.items():
        if not np.isfinite(values).all():
            raise PolicyFileError(f"{path}: {name} has a weight that is no finite number")


def check_sums(path: Path, network: Network, tensors: Mapping[str, Tensor]) -> None:
    """Check that no features make a unit overflow, because NaN outputs would silently select the first choice.

    The weights must have the shapes of the network.

    Raises:
        PolicyFileError: a unit may add up to more than `MOST_SUM`, or a weight is NaN or infinite.
    """

    def sums(layer: str, largest: Sizes, suffix: str = "") -> Sizes:
        """Return the largest absolute sums in a layer, shape (units,), from the largest absolute inputs."""
        weight, bias = (np.abs(tensors[f"{layer}.{part}{suffix}"].astype(np.float64)) for part in ("weight", "bias"))
        found: Sizes = weight @ largest + bias
        return found

    def check(layer: str, largest: Sizes) -> None:
        # NaN fails this comparison, too
        if not (largest <= MOST_SUM).all():
            raise PolicyFileError(f"{path}: the weights of {layer} are so large that it may overflow: train one anew")

    largest = np.full(network.entries, FEATURE_BOUND)
    if network.lstm:
        # the outputs of the GRU lie between -1 and 1
        shown = np.ones(network.lstm)
        check(GRU, sums(GRU, largest, "_ih_l0") + sums(GRU, shown, "_hh_l0"))
        largest = np.concatenate([shown, largest])
    for layer in network.linear():
        largest = sums(layer, largest)
        check(layer, largest)
        largest = np.minimum(largest, 1.0)


def read_description(path: Path, text: str | None) -> Description:
    """Return the description in the metadata of a file.

    Args:
        path: the file, for messages.
        text: description as JSON; None for a file without a description.

    Raises:
        PolicyFileError: the description is missing, damaged or of another version.
    """
    if text is None:
        raise PolicyFileError(f"{path} {NO_AGENT}: it has no description")
    try:
        document = json.loads(text)
        if type(document["format"]) is not int or document["format"] != FORMAT:
            raise PolicyFileError(f"{path} has format {quoted(document['format'])}, but this version reads {FORMAT}")
        if document.get(VERSION) != TASK_VERSION:
            task = shortened(str(document["task"]))
            raise PolicyFileError(
                f"{path} is {of_version(document.get(VERSION))}: train it anew for {task} with `grind train`"
            )
        known = {each.name: document[each.name] for each in fields(Description) if each.name in document}
        described: Description = formed(Description, known, "it")
    except PolicyFileError:
        raise
    except (FormError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise PolicyFileError(f"{path} {NO_AGENT}: its description is damaged ({reason(error)})") from None
    return described
