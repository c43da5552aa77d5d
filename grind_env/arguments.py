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


@dataclass(frozen=True, slots=True, kw_only=True)
class Reads:
    """An argument that names a file which is read, or something that may be one.

    Attributes:
        files: what is read with it, whether it is there or not, but for programs and their jobs.
        programs: part programs that it names. Programs that they call are read, too, and so is the job beside them
            where the command takes one and none is named.
    """

    files: Callable[[str], Iterable[Path]] = lambda text: ()
    programs: Callable[[str], Iterable[Path]] = lambda text: ()


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
    """Return what the arguments of a command are, by name; those that name no file are left out."""
    return {
        name: said
        for name, annotated in _annotated(function).items()
        for said in annotated
        if isinstance(said, Reads | Writes | Keeps | Asked)
    }


def checked(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a command that first finds out whether it may write its files; usual names are filled in.

    Raises:
        FileError: as of `check_targets`, when it is called.
    """
    roles, annotated = roles_of(function), _annotated(function)
    writes = {name: role for name, role in roles.items() if isinstance(role, Writes)}
    if not writes:
        return function

    @functools.wraps(function)
    def command(**arguments: Any) -> Any:
        program = next((program for role, text in _read(roles, arguments) for program in role.programs(text)), None)
        targets = list[Target]()
        for name, role in writes.items():
            named = arguments[name] is not None
            if not named and role.usual and program is not None:
                arguments[name] = beside(program, role.usual)
            path, option = arguments[name], _option(name, annotated[name])
            if path is not None:
                own = role.own if role.always or not named else None
                targets.append(Target(path=path, option=option, own=own, called=role.called))
                for suffix, other in (role.beside or {}).items():
                    targets.append(Target(path=beside(path, suffix), option=option, own=other, after=path))
        check_targets(targets, _files_read(roles, arguments))
        return function(**arguments)

    return command


def _files_read(roles: Mapping[str, Role], arguments: Mapping[str, Any]) -> Iterator[Path]:
    """Yield all files that a command reads, whether they are there or not."""
    from grind_env.control.options import interrupts_of
    from grind_env.control.reader import called_files

    asked = [text for name, role in roles.items() if isinstance(role, Asked) for text in _texts(arguments[name])]
    interrupts = [each.program for each in interrupts_of(asked)]
    jobs = [arguments[name] for name, role in roles.items() if role is JOB]
    for role, text in _read(roles, arguments):
        yield from role.files(text)
        for program in role.programs(text):
            yield program
            yield from called_files(program, interrupts)
            if jobs and not any(jobs):
                yield from job_files(str(beside(program, JOB_SUFFIX)))


def _read(roles: Mapping[str, Role], arguments: Mapping[str, Any]) -> Iterator[tuple[Reads, str]]:
    """Yield each text that names what is read, with its role."""
    for name, role in roles.items():
        if isinstance(role, Reads):
            yield from ((role, text) for text in _texts(arguments[name]))


def _texts(value: Any) -> list[str]:
    """Return an argument as the texts that were given."""
    return [] if value is None else [str(each) for each in (value if isinstance(value, list | tuple) else [value])]


def _option(name: str, annotated: Iterable[Any]) -> str:
    """Return the long option of an argument."""
    infos = [each for each in annotated if isinstance(each, OptionInfo)]
    texts = [text for info in infos for text in (info.default, *(info.param_decls or ()))]
    said = (text for text in texts if isinstance(text, str) and text.startswith("--"))
    return next(said, f"--{name.replace('_', '-')}")


def _annotated(function: Callable[..., Any]) -> dict[str, tuple[Any, ...]]:
    """Return what is said of the arguments of a command beside their types."""
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
