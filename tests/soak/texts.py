"""Random texts against the control.

Whatever a program holds, the control answers with motions or with a `ControlError` that names line and column; it
does not take long, nor outrun its block budget, nor keep memory.
"""

from tests.control.fuzz_cases import case
from tests.control.fuzz_examine import examine
from tests.soak.part import Part, Tried

DONE = "done"


def attempt(seed: int) -> Tried:
    """Check and execute the text of a seed."""
    end, finding = examine(case(seed), seed)
    if finding is not None:
        shown = f"{finding.details}\n{finding.case.settings} {finding.case.actions}\n{finding.case.text}"
        return Tried("fallen", finding.signature, shown)
    return Tried("accepted" if end == DONE else "refused", sums={end: 1})


PART = Part(name="texts", attempt=attempt, growth=50.0)
