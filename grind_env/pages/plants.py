"""The page of the out-of-model machines."""

from grind_env.data_table import Column, table_of
from grind_env.plants import FAMILIES
from grind_env.plants.family import Range

FILE = "plants.md"

INTRODUCTION = """\
A **plant** is a simulated machine whose physics differs from the model. Tests on plants show how a policy or program
that was tuned on the model does on another machine. The machines of a **family** differ from the model in one way, and
a seed draws their numbers. The sections below, *foreign* to *textbook*, describe them. A name says which machine:

| name | is |
| --- | --- |
| `meter:7` | the machine of the family *meter* that seed 7 draws |
| `foreign:3+meter:7` | a mix of families, in any order; at most one of *foreign*, *bursts*, *textbook* (other laws) |
| `held-out:5` | a machine for judging only: a mix of two to four families without *textbook* |
| `public:5` | a machine of the same kind to train and tune on |
| `held-out-laws:5` | a machine for judging only: *textbook*, and one to three other families |
| `laws:5` | a machine of the same kind to train and tune on |
| `training:5` | a machine of `public` or `laws`, half each: `grind train` trains on these |
| `meter`, `foreign+meter:7`, `public` | in environments: without a seed, a new machine in every episode |
| `module:name` | your own `Plant`, in a module that can be imported |
| `module:name:7` | a member of your own `Family`, alone or in a mix |
| `model` | the model itself |

```python
from grind_env.plants import find_plant

plant = find_plant("foreign:3+meter:7")
```

Environments take a name as `plant` (`make`, `make_vec`, `reset(options=...)`), task and job files as a key above their
tables, and the commands `run`, `report`, `play`, `optimise`, `advise` and `evaluate` as `--plant`
([how to](howto/evaluate.md)). A file must not name a module, because the code would be run.

A name draws the same numbers on every computer. Each number is drawn uniformly between the ends of its range, or
uniformly in its logarithm where the range says *factor*. **Held-out** machines have two to four of the families, with
at most one of *foreign* and *bursts*. Families and numbers come from random numbers that no other set uses; held-out
exponents of *textbook* lie outside the range of the exponents for training. Each number has a neutral value, at which
the machine behaves as the model, bit by bit. So the machines of a set share one process and can stand in one batch.

The random numbers of a shift (walks, chips, bursts) follow from the seed of the machine and the number of the block.
So `machine.grind` repeats an episode from its written program.

The source of a range says how far it can be trusted, as in [the validation](validation.md): *measured*; *drawn* from
data or tables that were seen; *remembered*, not looked up; *own*, this project's estimate. The ranges are frozen: a
change would invalidate published costs."""

RANGES = (
    Column("number", lambda each: f"`{each.field}`"),
    Column("what", "what"),
    Column("unit", lambda each: each.unit or None),
    Column("range", lambda each: _span(each)),
    Column("source", "basis"),
)


def plants_page() -> str:
    """Return the page, Markdown."""
    lines = ["# Out-of-model machines", INTRODUCTION]
    for family in FAMILIES:
        chances = " A seed of its random events is drawn, too." if family.chances else ""
        lines += [f"## {family.name}", f"{family.what[0].upper()}{family.what[1:]}.{chances}"]
        lines.append(table_of(RANGES, family.ranges).markdown())
    return "\n\n".join(lines) + "\n"


def _span(each: Range) -> str:
    judges = "" if each.held_out is None else "; held out {:g} to {:g}".format(*each.held_out)
    return f"{each.low:g} to {each.high:g}{judges}{', factor' if each.factor else ''}"
