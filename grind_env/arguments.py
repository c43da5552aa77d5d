"""Commands that lose no file: each says which of its arguments are files that it reads, and which it writes.

An annotation of an argument says it, beside that of Typer::

    program: Annotated[Path, typer.Argument(metavar="PROGRAM"), PROGRAM]
    plot: Annotated[Path | None, typer.Option(), Writes()] = None

Before such a command of an `Application` does anything, all that it would write is compared with all that it would
read, with what these files name in their turn, and with what it would take by itself.
"""

import functools
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import typer
from typer.models import OptionInfo

from grind_env.files import beside, is_file
from grind_env.targets import Own, Target, check_targets

Function = TypeVar("Function", bound=Callable[..., Any])

JOB_SUFFIX = ".toml"
"""Of tasks, and of the job that a program has if none is named."""


def none(text: str) -> Iterable[Path]:
    """No file."""
    return ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Reads:
    """An argument that names a file which is read, or something that may be one.

    Attributes:
        files: what is read with it, whether it is there or not, but for programs and their jobs.
        programs: part programs that it names. Programs that they call are read, too, and so is the job beside them
            where the command takes one and none is named.
    """

    files: Callable[[str], Iterable[Path]] = none
    programs: Callable[[str], Iterable[Path]] = none


@dataclass(frozen=True, slots=True, kw_only=True)
class Writes:
    """An argument that names a file which is written.

    Attributes:
        usual: suffix of the file that is written if none is named: that of the program.
        own: the only files that are replaced under the usual name, and if `always`, under any.
        always: whether a file that was named may be replaced only if it is the command's own, too.
        called: whether it may be a program that is read, if it is the command's own.
        beside: what is written beside it, by suffix.
    """

    usual: str = ""
    own: Own | None = None
    always: bool = False
    called: bool = False
    beside: Mapping[str, Own] | None = None


@dataclass(frozen=True, slots=True)
class Keeps:
    """An argument that names a folder in which a command keeps files under names of its own."""


@dataclass(frozen=True, slots=True)
class Asked:
    """An argument that names programs which the operator asks for, as `9200@12.5`."""


Role: TypeAlias = Reads | Writes | Keeps | Asked


class Application(typer.Typer):
    """Commands whose files are checked before they do anything."""

    def command(self, name: str | None = None, **settings: Any) -> Callable[[Function], Function]:
        """As that of Typer."""
        register = super().command(name, **settings)

        def add(function: Function) -> Function:
            register(checked(function))
            return function

        return add


def roles_of(function: Callable[..., Any]) -> dict[str, Role]:
    """What the arguments of a command are, by name; those that name no file are left out."""
    return {
        name: said
        for name, annotated in _annotated(function).items()
        for said in annotated
        if isinstance(said, Reads | Writes | Keeps | Asked)
    }


def checked(function: Callable[..., Any]) -> Callable[..., Any]:
    """A command that first finds out whether it may write what it is to write; usual names are filled in.

    Raises:
        FileError: as of `check_targets`, when it is called.
    """
    roles = roles_of(function)
    if not any(isinstance(role, Writes) for role in roles.values()):
        return function
    options = _options(function)

    @functools.wraps(function)
    def command(**arguments: Any) -> Any:
        program = next(_programs(roles, arguments), None)
        targets = list[Target]()
        for name, role in roles.items():
            if isinstance(role, Writes):
                named = arguments[name] is not None
                if not named and role.usual and program is not None:
                    arguments[name] = beside(program, role.usual)
                if arguments[name] is not None:
                    targets += _targets(role, arguments[name], named, options[name])
        check_targets(targets, files_read(roles, arguments))
        return function(**arguments)

    return command


def files_read(roles: Mapping[str, Role], arguments: Mapping[str, Any]) -> Iterator[Path]:
    """All files that a command reads, whether they are there or not.

    Args:
        roles: of its arguments.
        arguments: that it was given.
    """
    from grind_env.control.options import interrupts_of
    from grind_env.control.reader import called_files

    jobs = [name for name, role in roles.items() if role is JOB]
    asked = [text for name, role in roles.items() if isinstance(role, Asked) for text in _texts(arguments[name])]
    interrupts = [each.program for each in interrupts_of(asked)]
    for role, text in _read(roles, arguments):
        yield from role.files(text)
    for program in _programs(roles, arguments):
        yield program
        yield from called_files(program, interrupts)
        if jobs and not any(arguments[name] for name in jobs):
            yield from job_files(str(beside(program, JOB_SUFFIX)))


def _programs(roles: Mapping[str, Role], arguments: Mapping[str, Any]) -> Iterator[Path]:
    for role, text in _read(roles, arguments):
        yield from role.programs(text)


def _read(roles: Mapping[str, Role], arguments: Mapping[str, Any]) -> Iterator[tuple[Reads, str]]:
    """Each text that names what is read, with its role."""
    for name, role in roles.items():
        if isinstance(role, Reads):
            yield from ((role, text) for text in _texts(arguments[name]))


def _texts(value: Any) -> list[str]:
    """An argument as the texts that were given."""
    return [] if value is None else [str(each) for each in (value if isinstance(value, list | tuple) else [value])]


def _targets(role: Writes, path: Path, named: bool, option: str) -> Iterator[Target]:
    """The files that an argument stands for."""
    own = role.own if role.always or not named else None
    yield Target(path=path, option=option, own=own, called=role.called)
    for suffix, other in (role.beside or {}).items():
        yield Target(path=beside(path, suffix), option=option, own=other, after=path)


def _options(function: Callable[..., Any]) -> dict[str, str]:
    """The long options of a command, by the name of the argument."""
    options = {}
    for name, annotated in _annotated(function).items():
        infos = [each for each in annotated if isinstance(each, OptionInfo)]
        texts = [text for info in infos for text in (info.default, *(info.param_decls or ()))]
        said = (text for text in texts if isinstance(text, str) and text.startswith("--"))
        options[name] = next(said, f"--{name.replace('_', '-')}")
    return options


def _annotated(function: Callable[..., Any]) -> dict[str, tuple[Any, ...]]:
    """What is said of the arguments of a command beside their types."""
    parameters = inspect.signature(function, eval_str=True).parameters
    return {name: getattr(each.annotation, "__metadata__", ()) for name, each in parameters.items()}


def job_files(text: str) -> Iterable[Path]:
    """A job and its catalogue files."""
    from grind_env.machine.job.file import files_of_job

    return files_of_job(Path(text))


def task_files(text: str) -> Iterator[Path]:
    """What is read of a task file, or of several with commas between."""
    from grind_env.envs.tasks.reading import files_of_task

    for path in _named(text):
        if path.suffix.lower() == JOB_SUFFIX:
            yield from files_of_task(path)


def task_programs(text: str) -> Iterator[Path]:
    """Part programs that are named in place of a task."""
    return (path for path in _named(text) if path.suffix.lower() != JOB_SUFFIX)


def _named(text: str) -> Iterator[Path]:
    """The files in a list with commas between, in which names of tasks are none."""
    pieces = dict.fromkeys((text, *map(str.strip, text.split(","))))
    return (Path(piece) for piece in pieces if is_file(Path(piece)))


PROGRAM = Reads(programs=lambda text: [Path(text)])
JOB = Reads(files=job_files)
PROBLEM = Reads(files=task_files, programs=task_programs)
FILE = Reads(files=lambda text: [Path(text)])
CONFIGS = Reads(files=lambda text: Path(text).glob("*.toml"))
"""A folder of tuned parameters."""
