"""View of an evaluation: cost, scrap, E, D and score, with 95 % intervals."""

from grind_env.notebook_views.markup import fragment, table
from grind_env.policies.evaluation import Evaluation
from grind_env.policies.scoring import Judgement

HEADINGS = ("", "mean", "95 % interval")


def html(found: Evaluation | Judgement) -> str:
    """Return an evaluation or a judgement as HTML, one quantity in each row."""
    if isinstance(found, Evaluation):
        return fragment(f"{found.cost.size} episodes", table(HEADINGS, _rows(found)))
    rows = _rows(found.evaluation)
    if found.score is not None:
        how = "score" if found.paired else "score, unpaired"
        rows.append([how, f"{found.score.value:.1f}", f"{found.score.low:.1f} to {found.score.high:.1f}"])
    return fragment(f"{found.title}, {found.basis}", table(HEADINGS, rows))


def _rows(run: Evaluation) -> list[list[str]]:
    cost = run.cost_per_good_part
    return [
        ["cost, $ per good part", f"{cost.value:.3f}", f"{cost.low:.3f} to {cost.high:.3f}"],
        ["scrap, %", f"{100.0 * run.scrap:.2f}", ""],
        ["E, mm/min", f"{run.speed:.0f}", ""],
        ["D, dresses a block", f"{run.dresses:.2f}", ""],
    ]
