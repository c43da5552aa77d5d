"""No command overwrites one of its inputs: checked for every command, output and input."""

import functools
import inspect
import re
from collections.abc import Callable, Iterator
from itertools import permutations, product
from pathlib import Path
from typing import Any, NamedTuple, get_args

import pytest
import typer.main

from agents.command_line import app as agents
from grind_env.cli import app as grind
from grind_env.command_exit import command
from grind_env.file_arguments import CONFIGS, FILE, JOB, PROBLEM, PROGRAM, Reads, Writes, checked, roles_of


class Leaf(NamedTuple):
    """Command of `grind` or `python -m agents`."""

    words: tuple[str, ...]
    click: Any

    @property
    def function(self) -> Callable[..., Any]:
        return inspect.unwrap(self.click.callback)

    def option(self, name: str) -> str:
        """Return the option of an argument; empty for a positional one."""
        (parameter,) = (each for each in self.click.params if each.name == name)
        return next((text for text in parameter.opts if text.startswith("--")), "")

    def call(self, given: dict[str, str]) -> None:
        placed = [value for name, value in given.items() if not self.option(name)]
        options = [word for name, value in given.items() if (option := self.option(name)) for word in (option, value)]
        with command(self.words[0]):
            self.click([*options, "--", *placed])


def leaves(click: Any, words: tuple[str, ...]) -> Iterator[Leaf]:
    if hasattr(click, "commands"):
        for name, each in click.commands.items():
            yield from leaves(each, (*words, name))
    else:
        yield Leaf(words, click)


TREE = {
    " ".join(leaf.words): leaf
    for name, app in (("grind", grind), ("agents", agents))
    for leaf in leaves(typer.main.get_command(app), (name,))
}
WRITING = [name for name, leaf in TREE.items() if any(isinstance(r, Writes) for r in roles_of(leaf.function).values())]


def test_the_tree_has_all_commands() -> None:
    assert {"grind run", "grind advise", "grind figure dress", "agents video"} <= {*TREE}
    assert {"grind run", "grind report", "grind play", "grind advise", "agents video"} <= {*WRITING}


@pytest.mark.parametrize("name", TREE)
def test_every_path_argument_is_declared_as_read_or_written(name: str) -> None:
    leaf = TREE[name]
    roles = roles_of(leaf.function)
    for each in inspect.signature(leaf.function, eval_str=True).parameters.values():
        kind, *said = get_args(each.annotation) or (each.annotation,)
        is_path = Path in (kind, *get_args(kind))
        helped = "".join(info.help or "" for info in said if hasattr(info, "help"))
        if is_path or (kind is not bool and re.search(r"\bfiles?\b", helped, re.IGNORECASE)):
            assert each.name in roles, f"{name} {each.name}: {helped}"


CATALOGUES = '[catalogue]\nfiles = ["{}"]\n'
BESIDE = {"part.toml": CATALOGUES.format("shop.toml"), "shop.toml": "# shop\n"}
#: a program and its subprograms; the job beside it and another job, each with its catalogue
PROGRAMS = {
    "part.nc": "N10 G81 X9. P9100\n",
    "O9100.nc": "O9100 (OURS)\nM98 P0009200\nM99\n",
    "O9200.nc": "O9200\nG65 P7\nM99\n",
}
JOBS = {"job.toml": CATALOGUES.format("tools/own.toml"), "tools/own.toml": "# own\n"}
TASKS = {
    "task.toml": 'base = "base.toml"\n' + CATALOGUES.format("lots.toml"),
    "base.toml": CATALOGUES.format("more.toml"),
    "lots.toml": "# lots\n",
    "more.toml": "# more\n",
}


def situations(leaf: Leaf) -> Iterator[tuple[dict[str, str], dict[str, str]]]:
    """Yield sets of input arguments of a command, each with the names and texts of the files it then reads."""
    roles = {name: role for name, role in roles_of(leaf.function).items() if isinstance(role, Reads)}
    programs = [name for name, role in roles.items() if role is PROGRAM or role is PROBLEM]
    jobs = [name for name, role in roles.items() if role is JOB]
    given, read = dict[str, str](), dict[str, str]()
    for name, role in roles.items():
        if role is CONFIGS:
            given[name], read["tuned/part.toml"] = "tuned", "# tuned\n"
        elif name not in programs + jobs:
            assert role is FILE, f"{role}: say here what is read with it"
            given[name] = f"{name}.safetensors"
            read |= {given[name]: f"# {name}\n"}
    own_job = dict.fromkeys(jobs, "job.toml")
    if not programs:
        yield given | own_job, read | (JOBS if jobs else {})
    for name in programs:
        yield {**given, name: "part.nc", **own_job}, {**read, **PROGRAMS, **(JOBS if jobs else {})}
        required = [each for each in leaf.click.params if each.required]
        if jobs and not any(each.name in jobs for each in required):
            yield {**given, name: "part.nc"}, {**read, **PROGRAMS, **BESIDE}
        if roles[name] is PROBLEM:
            yield {**given, name: "task.toml"}, {**read, **TASKS}


def spellings(file: Path, folder: Path) -> Iterator[Path]:
    """Yield names of a file: its own, paths through other folders, and links."""
    yield file
    yield folder / "sub" / ".." / file
    yield Path(file)
    for number, link in enumerate((lambda path: path.symlink_to(file.resolve()), lambda path: path.hardlink_to(file))):
        path = folder / "sub" / f"link{number}{file.suffix}"
        path.unlink(missing_ok=True)
        link(path)
        yield path


def state_of(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def refused(leaf: Leaf, given: dict[str, str], capsys: pytest.CaptureFixture[str]) -> str:
    """Return the sentence with which a command refuses its arguments."""
    with pytest.raises(SystemExit) as ended:
        leaf.call(given)
    said = capsys.readouterr()
    assert (ended.value.code, said.out, said.err.count("\n")) == (2, "", 1), (given, said)
    return said.err


@pytest.mark.parametrize("name", WRITING)
def test_a_command_refuses_to_overwrite_its_inputs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    leaf, tried = TREE[name], 0
    outputs = {each: role for each, role in roles_of(leaf.function).items() if isinstance(role, Writes)}
    for number, (given, files) in enumerate(situations(leaf)):
        folder = tmp_path / str(number)
        for file, text in files.items():
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            (folder / file).write_text(text)
        (folder / "sub").mkdir()
        monkeypatch.chdir(folder)
        before = state_of(folder)
        for (output, role), file in product(outputs.items(), files):
            targets = list(spellings(Path(file), folder))
            if Path(file).suffix in (role.beside or {}):
                targets.append(Path(file).with_suffix(".beside"))
            for target in targets:
                message = refused(leaf, {**given, output: str(target)}, capsys)
                assert "would be lost" in message and leaf.option(output) in message, (given, target, message)
                assert re.search(r"name another file( with|$)", message), message
                assert Path(file).stem in message or target.stem in message
                tried += 1
        now = state_of(folder)
        assert {path: data for path, data in now.items() if "/sub/link" not in path} == before
    assert tried >= 10 * len(outputs) or name in ("agents scores", "agents track")  # they read one file


@pytest.mark.parametrize(
    "name",
    [
        each
        for each in WRITING
        if any(isinstance(role, Writes) and role.default_suffix for role in roles_of(TREE[each].function).values())
    ],
)
def test_a_default_output_never_replaces_an_input_or_a_users_file(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    leaf = TREE[name]
    monkeypatch.chdir(tmp_path)
    for role in [role for role in roles_of(leaf.function).values() if isinstance(role, Writes) and role.default_suffix]:
        usual = Path(f"part{role.default_suffix}")
        for file in [usual, *map(usual.with_suffix, role.beside or {})]:
            for text in ("mine\n", "<html>mine</html>", '{"steps": []}', "time,block\n", "#101=3\n"):
                (tmp_path / "part.nc").write_text("M30\n")
                (tmp_path / "part.toml").write_text("")
                file.write_text(text)
                assert "is there already and would be lost" in refused(leaf, {"program": "part.nc"}, capsys)
                assert file.read_text() == text
            for reads in [each for each, other in roles_of(leaf.function).items() if isinstance(other, Reads)]:
                if reads == "program" and file.with_suffix(role.default_suffix) != file:
                    continue
                given = {"program": "part.nc", reads: str(file)}
                assert "is read here and would be lost" in refused(leaf, given, capsys), given
                assert file.read_text() == text
            file.unlink()


@pytest.mark.parametrize("name", WRITING)
def test_outputs_must_be_distinct_files_in_existing_folders(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    leaf = TREE[name]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sub").mkdir()
    (tmp_path / "link.out").symlink_to("new.out")
    given, files = next(situations(leaf))
    for file, text in files.items():
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).write_text(text)
    outputs = {each: role for each, role in roles_of(leaf.function).items() if isinstance(role, Writes)}
    for one, other in permutations(outputs, 2):
        for target in ("new.out", "sub/../new.out", "NEW.out", "link.out"):
            message = refused(leaf, {**given, one: "new.out", other: target}, capsys)
            assert "would be written twice" in message
            assert leaf.option(one) in message and leaf.option(other) in message
        for suffix in outputs[one].beside or {}:
            assert "would be written twice" in refused(leaf, {**given, one: "new.out", other: f"new{suffix}"}, capsys)
    for one, role in outputs.items():
        assert "there is no folder none; make it first" in refused(leaf, {**given, one: "none/new.out"}, capsys)
        for suffix in role.beside or {}:
            assert "written beside it" in refused(leaf, {**given, one: f"new{suffix}"}, capsys)
            assert "is a device" in refused(leaf, {**given, one: "/dev/null"}, capsys)
    assert not list(tmp_path.rglob("new.*"))


def arguments_of(leaf: Leaf) -> dict[str, Any]:
    """Return the arguments of a command that is called without any."""
    parameters = inspect.signature(leaf.function).parameters.values()
    return {each.name: None if each.default is each.empty else each.default for each in parameters}


@pytest.mark.parametrize("name", WRITING)
def test_harmless_outputs_are_accepted(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    leaf, called = TREE[name], list[dict[str, Any]]()
    monkeypatch.chdir(tmp_path)

    @functools.wraps(leaf.function)
    def stub(**arguments: Any) -> None:
        called.append(arguments)

    (tmp_path / "part.nc").write_text("N10 G81 X9. P9100\nG04 P7\n")
    for other in ("O9101.nc", "O77.nc", "other.csv"):
        (tmp_path / other).write_text("old\n")
    for output, role in roles_of(leaf.function).items():
        if isinstance(role, Writes):
            roles = roles_of(leaf.function)
            programs = {each: "part.nc" for each, read in roles.items() if read is PROGRAM or read is PROBLEM}
            for target in (
                "new.nc",
                "sub/../new.nc",
                *(("O9101.nc", "O77.nc", "other.csv") if not role.always else ()),
            ):
                (tmp_path / "sub").mkdir(exist_ok=True)
                given = {**arguments_of(leaf), **programs, output: Path(target)}
                checked(stub)(**given)
                assert called.pop()[output] == Path(target)
