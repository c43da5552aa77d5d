"""A proposed program for the terminal: a table of its words, and sentences."""

from pathlib import Path
from typing import TYPE_CHECKING

from grind_env.errors import printable
from grind_env.shop.optimise.judgement import parts_said
from grind_env.shop.optimise.table import limit_text
from grind_env.shop.start.program import FINISH, ROUGH
from grind_env.shop.start.proposal import BATCH, ROOM, Proposal
from grind_env.shop.start.rules import OVERTRAVEL, PASSES, finish_stock
from grind_env.shop.trials import CONFIDENCE

if TYPE_CHECKING:
    from rich.console import Console

STAGES = {ROUGH: "rough", FINISH: "finish"}


def print_proposal(found: Proposal, program: Path, job: Path, console: "Console") -> None:
    """Print words and what sets them, what a part comes to, and what to grind first.

    Args:
        found: the proposal.
        program: its file, as it is named in what is to be done next.
        job: likewise.
        console: where to.
    """
    from rich.box import SIMPLE
    from rich.table import Column, Table

    numbers = [Column(name, justify="right", no_wrap=True) for name in ("word", "by rules", "proposed")]
    table = Table(Column("block", no_wrap=True), *numbers, "", "what sets it", box=SIMPLE, pad_edge=False)
    for word, why in found.reasons:
        place, after = STAGES.get(word.place, word.place), word.after if word.changed else "the same"
        table.add_row(place, word.name, word.before, after, word.unit, why)
    first, *others = map(printable, sentences(found, program, job))
    console.print(first, highlight=False, soft_wrap=True)
    console.print(table)
    for sentence in others:
        console.print(sentence, highlight=False, soft_wrap=True)


def sentences(found: Proposal, program: Path, job: Path) -> list[str]:
    """What is to be said, the first sentence above the table."""
    part, setup, cost, time = found.job.part, found.job.setup, found.cost, found.seconds
    known = "not calibrated" if found.job.uncertainty is None else "calibrated"
    good, low, high = (100.0 * share for share in found.good)
    shares = ", ".join(f"{100.0 * each.after:.0f} % of {each.name} {limit_text(each)}" for each in found.limits)
    narrow = [each.name for each in found.limits if not each.kept]
    said = [
        f"{part.material.name} with {setup.wheel.name} on {setup.machine.name}, {known}, batches of {BATCH} parts on "
        f"{found.machines} machines that this may be",
        f"{good:.1f} % of the parts are good ({low:.1f} to {high:.1f} on one machine, with 90 %), for {cost.value:.2f} "
        f"$ ({cost.low:.2f} to {cost.high:.2f}) and {time.value:.0f} s ({time.low:.0f} to {time.high:.0f}) each; by "
        f"the rules alone {100.0 * found.by_rules[0]:.1f} %, for {found.by_rules[1]:.2f} $",
        f"{parts_said(CONFIDENCE)} stay below {shares}, whatever their lot and the machine",
        f"not searched: {finish_stock(found.job):g} mm for finishing, {OVERTRAVEL:g} mm of overtravel, {PASSES} "
        f"passes a dress, the wheel at {setup.wheel_speed:g} m/s",
        f"{found.evaluations} program{'s' if found.evaluations > 1 else ''} tried",
    ]
    if narrow:
        said.append(
            f"{', '.join(narrow)}: no program was found that leaves {100.0 - 100.0 * ROOM:.0f} % of the limit free, "
            "which a machine of other laws may need: look there first"
        )
    if found.ended_early:
        said.append("the time was up before the search had ended: --budget gives it more, and the next run may differ")
    if found.job.uncertainty is None:
        plan = program.with_name("plan.nc")
        said.append(
            "nothing is known of your machine, which may obey other laws: watch the first part, and log the power of "
            f"the spindle; grind calibrate --plan {plan} --program {program} --job {job} writes a program whose log "
            "tells most; once it is calibrated, grind optimise finds cheaper words, and how seldom to dress"
        )
    return said
