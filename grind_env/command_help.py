"""The help of a command: one line, arguments and options in groups, and examples; it fits on a screen."""

from typing import Any

from typer.core import TyperArgument, TyperCommand

PART, SETTINGS, OUTPUT = "Part and machine", "Settings", "Output"
GROUPS = {
    PART: "job program parts variables plant block_delete blocks groove_retract dress_at interrupts",
    OUTPUT: "output plot record report html submit write state force plan as_json why window help",
}
"""Names of arguments by the group in which a help shows them; all others are settings."""
GROUP_OF = {name: group for group, names in GROUPS.items() for name in names.split()}


class HelpfulCommand(TyperCommand):
    """A command whose options stand in groups; its epilog has an example in each line."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        groups: dict[str, list[tuple[str, str]]] = {"Arguments": [], PART: [], SETTINGS: [], OUTPUT: []}
        for each in self.get_params(ctx):
            if record := each.get_help_record(ctx):
                group = "Arguments" if isinstance(each, TyperArgument) else GROUP_OF.get(each.name or "", SETTINGS)
                groups[group].append(record)
        for group, records in groups.items():
            if records:
                with formatter.section(group):
                    formatter.write_dl(records)

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        if self.epilog:
            with formatter.section("Examples"):
                for line in self.epilog.splitlines():
                    formatter.write(f"{'':{formatter.current_indent}}{line}\n")
