"""The inputs of a simulation by name: program and job, or task, for which an agent or a state was made."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, TypeAlias

from grind_env.control import ControlError
from grind_env.control.block_words import Word, read_block
from grind_env.control.macro_statements import label_of, with_label
from grind_env.control.program_reader import Program
from grind_env.control.program_scanner import SourceText
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.repeated_program import jumps
from grind_env.envs.simulation import Simulation
from grind_env.envs.tasks import Task
from grind_env.message_text import quoted, shortened
from grind_env.process.catalogue import USUAL

Inputs: TypeAlias = Mapping[str, str | float | bool]

#: fields of a job that describe the part and how to grind it. Plant, wear of the wheel and uncertainty are left out
JOB = "part", "setup", "times", "lots", "diamond", "stations", "parts", "variables"
#: fields of a task that do not change the simulation
NAMES_OF_TASKS = "name", "title", "reference_cost", "observation", "plant", "catalogue", "file"
#: names that `grind calibrate` changes beside those in the uncertainty of the job
CALIBRATED = "machine.idle_power", "machine.power_limit", "machine.meter_scale"
MOST_TOLD = 3

_NO_WORDS = re.compile(r"\([^()]*\)|\s")


def inputs_of(simulation: Simulation) -> Inputs:
    """Return the inputs of a simulation by name, in the units of job and task, without the plant."""
    if not isinstance(simulation, JobSimulation):
        return dict(named(_tables_of(simulation.task)))
    job = {name: getattr(simulation.job, name) for name in JOB}
    found = {"number of parts": simulation.parts, **dict(named(job))}
    # a batch counts as its original program; called programs are known after the batch has been executed
    for program in (simulation.once.main, *[*simulation.programs][1:]):
        name = "program" if program is simulation.once.main else f"O{program.number or program.place.file}"
        found |= {f"{name} block {place}": value for place, value in _words_of(program)}
    return found


def named(value: Any, name: str = "") -> Iterator[tuple[str, str | float | bool]]:
    """Yield the texts and numbers in nested tables, each with its name, such as `part.material.density`."""
    if is_dataclass(value):
        value = {each.name: getattr(value, each.name) for each in fields(value) if each.compare}
    elif isinstance(value, Sequence) and not isinstance(value, str):
        value = dict(enumerate(value, 1))
    if isinstance(value, Mapping):
        for key, each in value.items():
            yield from named(each, f"{name}.{key}" if name else str(key))
    elif value is not None:
        yield name, value


def differing(found: Inputs, before: Inputs) -> list[str]:
    """Return the names of different inputs; for a catalogue entry with another name, only that name."""
    names = [name for name in {**found, **before} if found.get(name) != before.get(name)]
    others = {name.removesuffix("name") for name in names if name.endswith(".name")}
    return [name for name in names if name.endswith(".name") or f"{name.rpartition('.')[0]}." not in others]


def describe_differences(names: Sequence[str], found: Inputs, before: Inputs) -> str:
    """Return the first differences as part of a sentence."""
    said = [f"{shortened(name)} is {_said(found, name)}, but was {_said(before, name)}" for name in names[:MOST_TOLD]]
    return "; ".join(said) + (f"; and {len(names) - MOST_TOLD} more" if len(names) > MOST_TOLD else "")


def calibrated(simulation: Simulation, names: Sequence[str]) -> bool:
    """Return whether a simulation has a calibrated job whose calibration may have changed all named inputs."""
    uncertainty = simulation.job.uncertainty if isinstance(simulation, JobSimulation) else None
    changed = () if uncertainty is None else (*uncertainty.names, *CALIBRATED)
    return all(".".join(name.split(".")[-2:]) in changed for name in names)


def _said(inputs: Inputs, name: str) -> str:
    return quoted(inputs[name]).removesuffix(".0") if name in inputs else "left out"


def _tables_of(task: Task) -> Mapping[str, Any]:
    """Return the tables of a task, with catalogue entries in place of their names."""
    tables = {each.name: getattr(task, each.name) for each in fields(task) if each.name not in NAMES_OF_TASKS}
    setup = {each.name: getattr(task.setup, each.name) for each in fields(task.setup)}
    overridden = {f"{kind}_overrides" for kind in USUAL}
    tables["setup"] = {name: value for name, value in setup.items() if name not in overridden}
    tables["setup"] |= {kind: getattr(task, kind) for kind in USUAL}
    tables["materials"] = [task.catalogue.materials[kind.material] for kind in task.kinds]
    return tables


def _words_of(program: Program) -> Iterator[tuple[str, str]]:
    """Yield the words of a program, each with the number of its block and its letter, such as `3 E`."""
    labelled = any(map(jumps, program.blocks))  # without jumps, N words have no effect
    number = 0
    for source in program.blocks:
        words = _words(source)
        number += bool(words)
        if labelled and (label := label_of(source.text)) is not None:
            words["N"] = str(label)
        yield from ((f"{number} {letter}", value) for letter, value in words.items())


def _words(source: SourceText) -> dict[str, str]:
    """Return the words of a block by letter, without N; for a statement or an unreadable block, its text."""
    found = {"/": "/"} if source.deletable else {}
    try:
        block = read_block(source)
    except ControlError:  # it may never be executed
        block = None
    if block is None or block.statement is not None:
        text = source.text if label_of(source.text) is None else with_label(source.text, 0)
        return found | {"text": _NO_WORDS.sub("", text.upper())}
    for word in block.words:
        found[word.letter] = f"{found.get(word.letter, '')} {_number(word)}".strip()
    return found


def _number(word: Word) -> str:
    """Return the number of a word in one form for all spellings, such as `5.` for `+05.0`."""
    if word.expression:
        return _NO_WORDS.sub("", word.expression.upper())
    point = f".{word.decimals.rstrip('0')}" if word.point else ""
    return f"{word.sign.strip('+')}{word.whole.lstrip('0') or 0}{point}"
