"""A proposed program as tables for the terminal."""

from pathlib import Path
from typing import TYPE_CHECKING

from grind_env.errors import printable
from grind_env.shop.optimise.judgement import parts_said
from grind_env.shop.optimise.table import limit_text
from grind_env.shop.start.program import FINISH, ROUGH
from grind_env.shop.start.proposal import ROOM, Proposal
from grind_env.shop.start.rules import OVERTRAVEL, PASSES, finish_stock, overlap_of
from grind_env.shop.trials import CONFIDENCE

if TYPE_CHECKING:
    from rich.console import Console

STAGES = {ROUGH: "rough", FINISH: "finish"}


def print_proposal(found: Proposal, program: Path, job: Path, console: "Console") -> None:
    """Print words and why they are so, what a part comes to, and what to grind first.

    Args:
        found: the proposal.
        program: its file, as it is named in what is to be done next.
        job: likewise.
        console: where to.
    """
    from rich.box import SIMPLE
    from rich.table import Column, Table

    def columns(*names: str) -> list[Column]:
        return [Column(name, no_wrap=True, justify="right" if k else "left") for k, name in enumerate(names)]

    part, setup = found.job.part, found.job.setup
    known = "not calibrated" if found.job.uncertainty is None else "calibrated"
    console.print(
        printable(
            f"{part.material.name} with {setup.wheel.name} on {setup.machine.name}, {known}, batches of {found.parts} "
            f"parts on {found.machines} machines that this may be"
        ),
        highlight=False,
    )
    words = Table(
        *columns("block", "word", "by rules", "proposed"), Column(""), Column("set"), box=SIMPLE, pad_edge=False
    )
    for word, why in found.reasons:
        stage = STAGES.get(word.place, word.place)
        words.add_row(stage, word.name, word.before, word.after if word.changed else "the same", word.unit, why)
    console.print(words)
    rows = {
        "good parts, %": (100.0, 1, found.good),
        "cost, $": (1.0, 2, found.cost),
        "time, s": (1.0, 1, found.seconds),
    }
    means = Table(*columns("of a part", "by rules", "proposed", "one machine (90 %)"), box=SIMPLE, pad_edge=False)
    for (name, (scale, digits, each)), before in zip(rows.items(), found.by_rules, strict=True):
        value, low, high = (f"{scale * number:.{digits}f}" for number in each)
        means.add_row(name, f"{scale * before:.{digits}f}", value, f"{low} to {high}")
    console.print(means)
    limits = Table(*columns("limit", "", "room", "by rules", "proposed"), box=SIMPLE, pad_edge=False)
    for limit in found.limits:
        shares = (f"{100.0 * share:.0f} %" for share in (ROOM, limit.before, limit.after))
        limits.add_row(limit.name, limit_text(limit), *shares)
    console.print(limits)
    for sentence in sentences(found, program, job):
        console.print(printable(sentence), highlight=False, soft_wrap=True)


def sentences(found: Proposal, program: Path, job: Path) -> list[str]:
    """What is to be said below the tables."""
    narrow = [each.name for each in found.limits if not each.kept]
    said = [
        f"{parts_said(CONFIDENCE)} stay below these shares of each limit, whatever their lot and the machine",
        f"by the rules alone: {finish_stock(found.job):g} mm for finishing, {OVERTRAVEL:g} mm of overtravel, "
        f"{PASSES} passes a dress, the wheel at {found.job.setup.wheel_speed:g} m/s; the overlap ratio of the dress is "
        f"{overlap_of(found.job, found.words):.1f}",
    ]
    if narrow:
        said.append(
            f"{', '.join(narrow)}: no program was found that leaves {100.0 - 100.0 * ROOM:.0f} % of the limit free, "
            "which a machine of other laws may need: look there first"
        )
    if found.ended_early:
        said.append("the time was up before the search had ended: --budget gives it more, and the next run may differ")
    said.append(f"{found.evaluations} program{'s' if found.evaluations > 1 else ''} tried, seed {found.seed}")
    if found.job.uncertainty is None:
        plan = program.with_name("plan.nc")
        said.append(
            "nothing is known of your machine, which may obey other laws: watch the first part, and log the power of "
            f"the spindle; grind calibrate --plan {plan} --program {program} --job {job} writes a program whose log "
            "tells most; once it is calibrated, grind optimise finds cheaper words, and how seldom to dress"
        )
    return said
