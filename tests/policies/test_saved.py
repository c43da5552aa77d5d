import base64
import importlib
import io
import json
import pickle
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from safetensors.numpy import load
from safetensors.numpy import save as tensors_with
from stable_baselines3.common.save_util import save_to_zip_file

from grind_env.errors import GrindError
from grind_env.policies.learned.agent_spaces import FEATURE_BOUND
from grind_env.policies.learned.saved import ENTRY, load_policy, write_policy
from grind_env.policies.problem_lookup import find_problem
from grind_env.sb3 import load_zip
from grind_env.task_version import TASK_VERSION
from tests.examples import examples
from tests.policies.untrained import ACTOR, recurrent, save, untrained

PROBLEM = find_problem("oracle6")
SIMULATION = PROBLEM.simulation()


@pytest.fixture(scope="module")
def model() -> Any:
    return untrained(PROBLEM)


@pytest.fixture(scope="module")
def good(model: Any, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("good") / "new" / "agent.safetensors"
    save(path, model, SIMULATION)
    assert [each.name for each in path.parent.iterdir()] == ["agent.safetensors"]
    return path.read_bytes()


def document_of(data: bytes) -> dict[str, Any]:
    (length,) = struct.unpack("<Q", data[:8])
    description: dict[str, Any] = json.loads(json.loads(data[8 : 8 + length])["__metadata__"][ENTRY])
    return description


def with_document(data: bytes, change: Callable[[dict[str, Any]], object]) -> bytes:
    document = document_of(data)
    change(document)
    return tensors_with(load(data), {ENTRY: json.dumps(document)})


def written(folder: Path, data: bytes) -> Path:
    path = folder / "agent.safetensors"
    path.write_bytes(data)
    return path


def refused(folder: Path, data: bytes, match: str, **arguments: Any) -> None:
    path = written(folder, data)
    with pytest.raises(GrindError, match=match) as caught:
        load_policy(path, **arguments)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


def test_an_agent_file_holds_the_actor_and_its_origin(good: bytes, model: Any):
    assert len(good) < 300_000
    document = document_of(good)
    assert document["settings"]["split"] == "inner"
    assert {"task": "oracle6", "kind": "ppo", "memory": "belief", "actions": "grid"}.items() <= document.items()
    state = model.policy.state_dict()
    tensors = load(good)
    assert len(tensors) == 2 * len(ACTOR)
    assert all(
        np.array_equal(tensors[f"{own}.{part}"], state[f"{name}.{part}"])
        for name, own in ACTOR.items()
        for part in ("weight", "bias")
    )


def test_a_missing_or_damaged_agent_file_is_refused(good: bytes, tmp_path: Path):
    with pytest.raises(GrindError, match="run `grind train` first"):
        load_policy(tmp_path / "none.safetensors")
    refused(tmp_path, b"", "holds no agent")
    refused(tmp_path, good[:-1], "holds no agent")
    refused(tmp_path, struct.pack("<Q", 1 << 62) + b"{}", "holds no agent")
    refused(tmp_path, tensors_with({"a": np.zeros(3, np.float32)}), "it has no description")
    refused(tmp_path, tensors_with(load(good), {ENTRY: "{"}), "description is damaged")
    refused(tmp_path, tensors_with(load(good), {ENTRY: "[" * 100_000}), "description is damaged")
    refused(tmp_path, tensors_with(load(good), {ENTRY: '{"format": ' + "9" * 5000 + "}"}), "description is damaged")
    refused(tmp_path, good, "was trained for oracle6, not for slot", simulation=find_problem("slot").simulation())


@pytest.mark.parametrize(
    ("version", "said"),
    [
        (None, "1"),
        (1, "1"),
        (TASK_VERSION + 1, str(TASK_VERSION + 1)),
        ("\x1b[2J", r"'\\x1b\[2J'"),
        ([2] * 999, r"\[2, "),
    ],
)
def test_an_agent_of_another_task_version_is_refused(version: Any, said: str, good: bytes, tmp_path: Path):
    assert document_of(good)["task_version"] == TASK_VERSION
    old = with_document(good, lambda document: document.update(task_version=version))
    now = f"and the tasks are now of version {TASK_VERSION}"
    remedy = "train it anew for oracle6 with `grind train`"
    refused(tmp_path, old, f"agent.safetensors is of task version {said}.*{now}: {remedy}")
    unnumbered = with_document(good, lambda document: document.pop("task_version"))
    refused(tmp_path, unnumbered, f"is of task version 1, {now}: {remedy}", simulation=SIMULATION)


class Dangerous:
    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> Any:
        return Path.touch, (self.path,)


def test_a_pickle_runs_only_when_trusted(model: Any, tmp_path: Path):
    ran = tmp_path / "ran"
    refused(tmp_path, pickle.dumps(Dangerous(ran)), "holds no agent")
    with pytest.raises(GrindError, match="holds no model of Stable-Baselines3"):
        load_zip(written(tmp_path, pickle.dumps(Dangerous(ran))), SIMULATION)
    buffer = io.BytesIO()
    save_to_zip_file(buffer, data={"policy_class": Dangerous(ran)})
    refused(tmp_path, buffer.getvalue(), "can run code of its author: give a .safetensors file, or --trust")
    assert not ran.exists()
    with pytest.raises(GrindError, match="holds no model of Stable-Baselines3"):
        load_zip(written(tmp_path, buffer.getvalue()), SIMULATION)
    assert ran.exists()


class Missing:
    """Object whose unpickling imports a missing module."""

    def __reduce__(self) -> Any:
        return importlib.import_module, ("a_module_that_is_not_there",)


@pytest.mark.parametrize("junk", [b"", b"junk", b"\x80\x02junk", b"P" * 40, bytes(40), pickle.dumps({"a": 1})])
def test_a_trusted_zip_with_junk_in_it_is_refused(junk: bytes, model: Any, tmp_path: Path):
    model.save(tmp_path / "whole.zip")
    buffer = io.BytesIO()
    with zipfile.ZipFile(tmp_path / "whole.zip") as whole, zipfile.ZipFile(buffer, "w") as changed:
        for name in whole.namelist():
            changed.writestr(name, junk if name == "policy.pth" else whole.read(name))
    with pytest.raises(GrindError, match="holds no model of Stable-Baselines3"):
        load_zip(written(tmp_path, buffer.getvalue()), SIMULATION)


def test_a_trusted_zip_with_a_missing_module_is_refused(tmp_path: Path):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as made:
        made.writestr("data", "{}")
        made.writestr("policy.pth", pickle.dumps(Missing()))
    with pytest.raises(GrindError, match="holds no model of Stable-Baselines3"):
        load_zip(written(tmp_path, buffer.getvalue()), SIMULATION)
    buffer = io.BytesIO()
    serialized = base64.b64encode(pickle.dumps(Missing())).decode()
    with zipfile.ZipFile(buffer, "w") as made:
        made.writestr("data", json.dumps({"policy_class": {":serialized:": serialized}}))
    with pytest.raises(GrindError, match="a_module_that_is_not_there"):
        load_zip(written(tmp_path, buffer.getvalue()), SIMULATION)


@pytest.mark.parametrize(
    ("key", "value", "match"),
    [
        ("format", 2, "has format 2, but this version reads 1"),
        ("format", True, "has format True, but this version reads 1"),
        ("format", 1.0, r"has format 1\.0, but this version reads 1"),
        ("format", "1" * 600_000, r"has format '1+\.\.\. \(600002 characters\), but this version reads 1"),
        ("task", "unheard_of", "there is no problem 'unheard_of'"),
        ("task", "../../etc/passwd", "description is damaged"),
        ("task", "slot", "was trained for another part: blocks is 30, but was 6"),
        ("task", ["oracle6"], "description is damaged"),
        ("kind", "\x1b[2J", "description is damaged"),
        ("memory", "elephant", "description is damaged"),
        ("memory", {}, "description is damaged"),
        ("memory", "stack", "another version of oracle6"),
        ("actions", "index", "description is damaged"),
        ("spaces", "0" * 64, "another version of oracle6"),
        ("network", None, "description is damaged"),
    ],
)
def test_a_wrong_description_is_refused(key: str, value: Any, match: str, good: bytes, tmp_path: Path):
    refused(tmp_path, with_document(good, lambda document: document.update({key: value})), match)


@pytest.mark.parametrize(
    ("key", "value", "match"),
    [
        ("family", "os.system", "description is damaged"),
        ("entries", 10**9, "description is damaged"),
        ("entries", True, "description is damaged"),
        ("entries", 12, "its tensors are not those"),
        ("hidden", [128], "its tensors are not those"),
        ("hidden", [60_000] * 16, "its tensors are not those"),
        ("hidden", [1] * 17, "description is damaged"),
        ("hidden", [128.0, 128.0], "description is damaged"),
        ("hidden", "128", "description is damaged"),
        ("lstm", 64, "its tensors are not those"),
        ("activation", "relu", "description is damaged"),
    ],
)
def test_a_wrong_network_is_refused(key: str, value: Any, match: str, good: bytes, tmp_path: Path):
    refused(tmp_path, with_document(good, lambda document: document["network"].update({key: value})), match)


def test_wrong_tensors_are_refused(good: bytes, tmp_path: Path):
    metadata = {ENTRY: json.dumps(document_of(good))}
    for change, match in (
        (lambda values: np.full_like(values, np.nan), "no finite number"),
        (lambda values: np.where(np.arange(len(values)) == 3, np.inf, values).astype(np.float32), "no finite number"),
        (lambda values: values.astype(np.float64), "its tensors are not those"),
        (lambda values: values[1:], "its tensors are not those"),
        (lambda values: values[:, None], "its tensors are not those"),
    ):
        tensors = load(good)
        tensors["actor.4.bias"] = change(tensors["actor.4.bias"])
        refused(tmp_path, tensors_with(tensors, metadata), match)
    tensors = load(good)
    refused(tmp_path, tensors_with({**tensors, "more": np.zeros(1, np.float32)}, metadata), "its tensors are not those")
    del tensors["actor.4.bias"]
    refused(tmp_path, tensors_with(tensors, metadata), "its tensors are not those")


LAYERS = tuple(ACTOR.values())


def with_factors(data: bytes, factors: dict[str, float]) -> bytes:
    tensors = load(data)
    for name, factor in factors.items():
        with np.errstate(over="ignore"):
            tensors[name] = (tensors[name].astype(np.float64) * factor).astype(np.float32)
    return tensors_with(tensors, {ENTRY: json.dumps(document_of(data))})


@pytest.mark.parametrize("layer", LAYERS)
def test_overflowing_finite_weights_are_refused(layer: str, good: bytes, tmp_path: Path):
    largest = float(np.abs(load(good)[f"{layer}.weight"]).max())
    data = with_factors(good, {f"{layer}.weight": 3e38 / largest})
    assert all(np.isfinite(values).all() for values in load(data).values())
    refused(tmp_path, data, f"the weights of {layer} are so large that it may overflow: train one anew")


def test_an_overflowing_gru_is_refused(tmp_path: Path):
    path, agent = tmp_path / "agent.safetensors", recurrent(SIMULATION)
    write_policy(path, agent.actor, SIMULATION, "gru", agent.form, {})
    data = path.read_bytes()
    for part in ("ih", "hh"):
        refused(tmp_path, with_factors(data, {f"gru.weight_{part}_l0": 1e38}), "the weights of gru are so")


@examples(40)
@given(powers=st.tuples(*[st.integers(0, 39)] * 3), seed=st.integers(0, 2**32 - 1))
@example(powers=(35, 35, 35), seed=0)
def test_an_accepted_agent_does_not_overflow(powers: tuple[int, ...], seed: int, good: bytes, tmp_path: Path):
    factors = {f"{layer}.weight": 10.0**power for layer, power in zip(LAYERS, powers, strict=True)}
    path = tmp_path / "agent.safetensors"
    path.write_bytes(with_factors(good, factors))
    try:
        actor = load_policy(path).actor
    except GrindError as error:
        assert "overflow" in str(error) or "no finite number" in str(error)
        return
    # the features with the largest sums in the first layer, and random ones
    worst = np.sign(actor.tensors["actor.0.weight"])
    signs = np.concatenate([worst, np.random.default_rng(seed).choice([-1.0, 1.0], worst.shape)])
    features = (FEATURE_BOUND * signs).astype(np.float32)
    with np.errstate(over="raise", invalid="raise"):
        values, _ = actor.outputs(features, actor.begin(len(features)))
    assert np.isfinite(values).all()


def test_an_overflowing_network_is_not_saved(tmp_path: Path):
    model = untrained(PROBLEM)
    model.policy.action_net.weight.data[:] = 3e38
    with pytest.raises(GrindError, match=r"the weights of actor\.4 are so large"):
        save(tmp_path / "agent.safetensors", model, SIMULATION)
    model.policy.action_net.bias.data[0] = float("nan")
    with pytest.raises(GrindError, match="no finite number"):
        save(tmp_path / "agent.safetensors", model, SIMULATION)
    assert list(tmp_path.iterdir()) == []


@examples(150)
@given(cut=st.integers(0, 400), where=st.integers(0, 2400), mask=st.integers(0, 255), tail=st.binary(max_size=8))
def test_a_damaged_file_loads_or_is_refused_in_one_line(
    cut: int, where: int, mask: int, tail: bytes, good: bytes, tmp_path: Path
):
    data = bytearray(good)
    data[where] ^= mask
    path = tmp_path / "agent.safetensors"
    path.write_bytes(bytes(data[: len(data) - cut]) + tail)
    try:
        policy = load_policy(path)
    except GrindError as error:
        assert "\n" not in str(error)
    else:
        # flipped bits may spell another number or version
        policy.begin(SIMULATION, 1)
        policy.act(np.zeros((1, len(SIMULATION.entries)), np.float32), None)


@pytest.mark.parametrize("name", ["größe", "my-shop 2", "v1.2"])
def test_an_agent_of_a_task_file_with_any_name_is_loaded(name: str, good: bytes, tmp_path: Path):
    (tmp_path / f"{name}.toml").write_text('base = "oracle6"', encoding="utf-8")
    path = tmp_path / "agent.safetensors"
    path.write_bytes(with_document(good, lambda document: document.update(task=name)))
    simulation = find_problem(str(tmp_path / f"{name}.toml")).simulation()
    assert load_policy(path, simulation=simulation).name == "ppo"
