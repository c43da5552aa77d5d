"""The help of commands on one screen: one line, options in groups, examples; and renamed options."""

import re
from typing import Any, ClassVar

from typer.core import TyperArgument, TyperCommand, TyperGroup

from grind_env.errors import GrindError

#: new name of each renamed option; another command may still have an option of the old name
RENAMED = {
    "--blocks": "--max-blocks",
    "--budget": "--max-scrap",
    "--by": "--rows",
    "--configs": "--parameters",
    "--every": "--dress-every",
    "--first": "--first-seed",
    "--for": "--objective",
    "--grid": "--full",
    "--keep": "--fix",
    "--map": "--columns",
    "--pictures": "--frames",
    "--runs": "--cache",
    "--step": "--max-step",
    "--why": "--explain",
    "--within": "--constraint",
}

PART, SETTINGS, RUNNING, OUTPUT = "Task, part and machine", "Settings", "Running", "Output"
#: names of arguments by the group in which a help shows them; all others are settings
GROUPS = {
    PART: "env task tasks family machines job program parts variables plant block_delete max_blocks groove_retract "
    "dress_at interrupts",
    RUNNING: "jobs ray runs configs fresh hours trust",
    OUTPUT: "output csv plot record report html submit write state force plan as_json explain window results published "
    "help",
}
GROUP_OF = {name: group for group, names in GROUPS.items() for name in names.split()}


class HelpfulCommand(TyperCommand):
    """Command with its options in groups; each line of its epilog is an example."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        try:
            return super().parse_args(ctx, args)
        except Exception as error:  # the error class for an unknown option depends on the versions of Typer and Click
            new = RENAMED.get(old := getattr(error, "option_name", ""))
            if any(new in each.opts for each in self.params):
                raise GrindError(f"{old} was renamed to {new}") from None
            raise

    def format_options(self, ctx: Any, formatter: Any) -> None:
        groups: dict[str, list[tuple[str, str]]] = {"Arguments": [], PART: [], SETTINGS: [], RUNNING: [], OUTPUT: []}
        for each in self.get_params(ctx):
            if record := each.get_help_record(ctx):
                group = "Arguments" if isinstance(each, TyperArgument) else GROUP_OF.get(each.name or "", SETTINGS)
                names = re.sub(r"(--[\w-]+)(, --[\w-]+)+", r"\1", record[0])
                names = re.sub(r"<(?:list\[)?(\w+)\]?(?: range)?>", r"<\1>", names)
                groups[group].append((names, re.sub(r"  \[x>=\d+\]|; x>=\d+(?=\])", "", record[1])))
        for group, records in groups.items():
            if records:
                with formatter.section(group):
                    formatter.write_dl(records)

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        if self.epilog:
            with formatter.section("Examples"):
                for line in self.epilog.splitlines():
                    formatter.write(f"{'':{formatter.current_indent}}{line}\n")


class HelpfulGroup(TyperGroup):
    """Command list in groups, with the whole first line of each command's help."""

    groups: ClassVar[dict[str, str]] = {}  #: names of commands by the group in which the help shows them

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        for group, names in (self.groups or {"Commands": " ".join(self.commands)}).items():
            with formatter.section(group):
                formatter.write_dl(
                    [(each, (self.commands[each].help or "").partition("\n")[0]) for each in names.split()]
                )
