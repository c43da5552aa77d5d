"""File arguments of commands: which files a command reads and writes, so that no input is overwritten.

An annotation beside Typer's marks a file: `plot: Annotated[Path | None, typer.Option(), Writes()] = None`. Before a
command of an `Application` starts, each output file is compared with the input files, the files named in them and
the default files.
"""

import functools
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias, TypeVar

import typer
from typer.models import OptionInfo

from grind_env.command_help import HelpfulCommand, HelpfulGroup
from grind_env.files import beside, is_file
from grind_env.output_checks import FileKind, Target, check_targets
from grind_env.toml import files_named

Function = TypeVar("Function", bound=Callable[..., Any])

#: suffix of task files and job files; the default job of a program has the program's name with this suffix
JOB_SUFFIX = ".toml"


class Reads(NamedTuple):
    """Argument that names one or more input files, separated by commas.

    `within` is the glob pattern of the files that are read from a folder. With `programs`, a file other than .toml is a
    part program: the programs that it calls are read, too. So is the job beside it, if the command has a job argument
    and the user names no job.
    """

    within: str = ""
    programs: bool = False

    def named(self, text: str) -> Iterator[Path]:
        """Yield the paths that the text of an argument may name."""
        pieces = dict.fromkeys((text, *map(str.strip, text.split(","))))
        return Path(text).glob(self.within) if self.within else map(Path, pieces)


class Writes(NamedTuple):
    """Argument that names an output file.

    `default_suffix` is that of the default file, named after the program. A file of the default name is replaced only
    if `replaceable` recognises it; with `always` this holds for every name. With `may_be_input`, the file may be one of
    the input programs. `beside` has the suffixes and kinds of further files that are written beside it.
    """

    default_suffix: str = ""
    replaceable: FileKind | None = None
    always: bool = False
    may_be_input: bool = False
    beside: Mapping[str, FileKind] = {}


class Keeps(NamedTuple):
    """Argument that names a folder for files whose names the command chooses."""


class Requests(NamedTuple):
    """Argument that names programs which the operator requests, such as `9200@12.5` (program number, time in s)."""


Role: TypeAlias = Reads | Writes | Keeps | Requests

PROGRAM = Reads(programs=True)
PROBLEM = Reads(programs=True)  #: one or several problems, each a task (name or file) or a part program
JOB, FILE, CONFIGS = Reads(), Reads(), Reads(within="*.toml")  #: a job, any file, a folder of tuned parameters


class Application(typer.Typer):
    """Typer application that checks the files of a command before the command runs."""

    def __init__(self, **settings: Any) -> None:
        plain = {"add_completion": False, "pretty_exceptions_enable": False, "rich_markup_mode": None}
        super().__init__(**{"cls": HelpfulGroup, **plain, **settings})

    def command(self, name: str | None = None, **settings: Any) -> Callable[[Function], Function]:
        register = super().command(name, **{"cls": HelpfulCommand, **settings})

        def add(function: Function) -> Function:
            register(checked(function))
            return function

        return add


def roles_of(function: Callable[..., Any]) -> dict[str, Role]:
    """Return the roles of the file arguments of a command, by argument name."""
    said = ((name, each) for name, annotated in _annotated(function).items() for each in annotated)
    return {name: each for name, each in said if isinstance(each, Reads | Writes | Keeps | Requests)}


def checked(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a command that fills in default file names and checks its output files before it runs.

    Raises:
        FileError: as in `check_targets`, when the command is called.
    """
    roles, annotated = roles_of(function), _annotated(function)
    writes = {name: role for name, role in roles.items() if isinstance(role, Writes)}
    if not writes:
        return function

    @functools.wraps(function)
    def command(**arguments: Any) -> Any:
        program = next((Path(text) for role, text in _given(roles, arguments) if role is PROGRAM), None)
        targets = list[Target]()
        for name, role in writes.items():
            named = arguments[name] is not None
            if not named and role.default_suffix and program is not None:
                arguments[name] = beside(program, role.default_suffix)
            path, option = arguments[name], _option(name, annotated[name])
            if path is not None:
                own = role.replaceable if role.always or not named else None
                targets.append(Target(path=path, option=option, replaceable=own, may_be_input=role.may_be_input))
                for suffix, other in role.beside.items():
                    targets.append(Target(path=beside(path, suffix), option=option, replaceable=other, main_file=path))
        check_targets(targets, _files_read(roles, arguments))
        return function(**arguments)

    return command


def _files_read(roles: Mapping[str, Role], arguments: Mapping[str, Any]) -> Iterator[Path]:
    """Yield all files that a command reads; called programs and files named in a TOML file may be missing."""
    from grind_env.control.cli_options import interrupts_of
    from grind_env.control.program_reader import called_files

    given = _given(roles, arguments)
    interrupts = [each.program for each in interrupts_of([text for role, text in given if isinstance(role, Requests)])]
    needs_job = any(role is JOB for role in roles.values()) and not any(role is JOB for role, _ in given)
    reads = ((role, path) for role, text in given if isinstance(role, Reads) for path in role.named(text))
    for role, path in reads:
        if not is_file(path):
            continue
        if role is JOB or path.suffix.lower() == JOB_SUFFIX:
            yield from files_named(path)
        else:
            yield from (path, *(called_files(path, interrupts) if role.programs else ()))
            if role.programs and needs_job:
                yield from files_named(beside(path, JOB_SUFFIX))


def _given(roles: Mapping[str, Role], arguments: Mapping[str, Any]) -> list[tuple[Role, str]]:
    """Return role and text of each file argument that has a value."""
    values = ((role, arguments[name]) for name, role in roles.items() if arguments[name])
    return [(role, str(each)) for role, value in values for each in (value if isinstance(value, list) else [value])]


def _option(name: str, annotated: Iterable[Any]) -> str:
    infos = [each for each in annotated if isinstance(each, OptionInfo)]
    texts = [text for info in infos for text in (info.default, *(info.param_decls or ()))]
    said = (text for text in texts if isinstance(text, str) and text.startswith("--"))
    return next(said, f"--{name.replace('_', '-')}")


def _annotated(function: Callable[..., Any]) -> dict[str, tuple[Any, ...]]:
    """Return the `Annotated` metadata of the arguments of a command, by argument name."""
    parameters = inspect.signature(function, eval_str=True).parameters
    return {name: getattr(each.annotation, "__metadata__", ()) for name, each in parameters.items()}
