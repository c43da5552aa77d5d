"""Checks of a program and its job: all ways of running it give equal results, or one sentence says why not."""

import math
import random
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any
from unittest.mock import patch

import numpy as np

from grind_env.array_types import Array
from grind_env.control import ControlError, Dwell, check, read
from grind_env.control.control_settings import WHEEL_RADIUS
from grind_env.envs.cost import Outcome
from grind_env.envs.job.job_simulation import JobSimulation
from grind_env.envs.job.program_outline import JobProgramError
from grind_env.envs.job.repeated_program import with_words_chosen
from grind_env.envs.program_episode import PassageError, ProgramEpisode
from grind_env.errors import GrindError
from grind_env.machine.dress.mounted_wheel import first_diameter
from grind_env.machine.grind import grind, refuse_unjudged
from grind_env.machine.job import JobError
from grind_env.machine.loops.stroke_totals import Tally
from grind_env.machine.part.unsimulated_cuts import UnjudgedError
from grind_env.machine.record import GrindingRecord
from grind_env.machine.script import script
from grind_env.machine.script.script import script_of
from grind_env.machine.script.script_block import ScriptError
from grind_env.machine.script.script_tables import BlockRow
from grind_env.process.cost import STALL
from tests.machine.harness import machine_after
from tests.soak.limits import TooSlowError, limited
from tests.soak.part import fallen
from tests.soak.writer import Case

SLOW = 5.0  #: processor time that a program may take in each way of running it, s
FINISH, ENDS_PART = (BlockRow._fields.index(name) for name in ("finish", "ends_part"))
QUICK = 1e-3  #: processor time that a longer program may take for each motion and run, s
SUM = 1e-9  #: relative tolerance of sums over a run, and of results that depend on such sums
NAME = "campaign.nc"
SHARED = " at once, which is not simulated"  #: part of the message about strokes that meet two stations
UNCONDITIONED = " grinds more parts than the "  #: part of the error about a run with more parts than conditions
SLOWED = 1.001  #: multiple of the torque at the power limit above which the spindle counts as slowed
#: one in this many programs without a script is stepped by the control, which runs the program seven times
STEPPED_BY_CONTROL = 4


@dataclass(frozen=True, slots=True)
class Finding:
    """Fault that a program has shown."""

    kind: str  # short text, equal for all programs with the fault
    details: str  # traceback or numbers


@dataclass(slots=True)
class Examined:
    """Results of a program in all ways of running it."""

    end: str = ""  # "ground", or the name of the error that refuses the program
    replay: str = ""  # "script", or why the program has no script or is not stepped
    happened: set[str] = field(default_factory=set)  # names of the events during grinding
    strokes: int = 0
    # numbers of values of wheels after a block that equal the machine's to the bit, and that were compared
    exact: tuple[int, int] = (0, 0)
    findings: list[Finding] = field(default_factory=list)

    def differ(self, kind: str, found: object, expected: object) -> None:
        """Record a difference."""
        self.findings.append(Finding(kind, f"{found!r} instead of {expected!r}"))


def examine(case: Case, seconds: float = SLOW) -> Examined:
    """Run a program in all ways and compare the results."""
    examined = Examined()
    ways = (("check", _check, 1), ("run", _run, 2), ("replay", _replay, 10))
    known: dict[str, Any] = {}
    for name, way, runs in ways:
        began = time.process_time()
        try:
            with limited(max(seconds, QUICK * runs * known.get("motions", 0))):
                go_on = way(case, examined, known)
        except TooSlowError:
            spent = time.process_time() - began
            examined.findings.append(
                Finding(f"{name}: slow", f"more than {seconds:g} s of processor time ({spent:.1f})")
            )
            break
        except Exception as error:
            fell = fallen(error)
            examined.findings.append(Finding(f"{name}: {fell.kind}", fell.details))
            break
        if not go_on:
            break
    return examined


def _check(case: Case, examined: Examined, known: dict[str, Any]) -> bool:
    try:
        known["programs"] = read(case.text, NAME)
    except ControlError as error:
        examined.end = error.name
        return False
    radius = {WHEEL_RADIUS: 0.5 * first_diameter(case.job)}
    report = check(known["programs"], replace(case.job.control, radii=radius))
    known["motions"] = report.motions
    known["checked"] = "; ".join(map(str, report.errors)) or None
    for error in report.errors:
        _require_sentence(error, examined)
    return True


def _run(case: Case, examined: Examined, known: dict[str, Any]) -> bool:
    """Grind the program as a whole and stroke by stroke, and compare the records."""
    programs, job = known["programs"], case.job
    whole = _record(lambda: grind(programs, job))
    # the control announces every stroke
    stepped = _record(lambda: machine_after(programs, job).record())
    for error in (whole, stepped):
        if isinstance(error, GrindError):
            _require_sentence(error, examined)
    if isinstance(whole, GrindError) or isinstance(stepped, GrindError):
        error = whole if isinstance(whole, GrindError) else stepped
        examined.end = error.name if isinstance(error, ControlError) else type(error).__name__
        if _counts_otherwise(whole, stepped):
            return False
        if str(whole) != str(stepped):
            examined.differ("run: refused in one way", str(whole)[:300], str(stepped)[:300])
        known["refused"] = str(error)
        return True
    examined.end, examined.strokes = "ground", int(whole.strokes.size)
    if known["checked"] is not None:
        examined.differ("check: refuses a program that is ground", known["checked"], "ground")
    _record_events(whole, examined)
    known["record"] = whole
    if examined.happened & {"stations met at once"}:
        _compare_shared(whole, stepped, examined)
        return True
    dressed = bool((whole.dresses["cause"] == "auto").any())
    for name in ("strokes", "dresses", "parts"):
        _compare_tables(
            f"run: {name} stroke by stroke", getattr(whole, name), getattr(stepped, name), dressed, examined
        )
    if sorted(whole.warnings) != sorted(stepped.warnings):
        odd = sorted(set(whole.warnings) ^ set(stepped.warnings))
        examined.differ("run: warnings stroke by stroke", odd, [])
    if whole.unjudged != stepped.unjudged:
        examined.differ("run: not judged stroke by stroke", str(whole.unjudged)[:300], str(stepped.unjudged)[:300])
    if whole.stages != stepped.stages:
        examined.differ("run: stages stroke by stroke", whole.stages, stepped.stages)
    return True


def _counts_otherwise(*ways: GrindingRecord | GrindError) -> bool:
    """Return whether strokes that meet two stations explain that only one way has parts without conditions."""
    refused = any(isinstance(way, GrindError) and UNCONDITIONED in str(way) for way in ways)
    return refused and any(isinstance(way, GrindingRecord) and _shares(way) for way in ways)


def _shares(record: GrindingRecord) -> bool:
    """Return whether a stroke of a record meets two stations."""
    return any(SHARED in each.why for found in record.unjudged for each in found)


def _compare_shared(whole: GrindingRecord, stepped: GrindingRecord, examined: Examined) -> None:
    """Compare runs with strokes that meet two stations: one way assigns cycles to parts, the other single strokes."""
    for name in ("seconds", "line", "E"):
        found, expected = whole.strokes[name], stepped.strokes[name]
        if not np.array_equal(found, expected):
            examined.differ(f"run: strokes stroke by stroke, shared: {name}", found, expected)
    # which parts are not judged depends on the way: after M00 the table may come to rest at another station
    if not (any(whole.unjudged) and any(stepped.unjudged)):
        examined.differ("run: not judged stroke by stroke, shared", whole.unjudged, stepped.unjudged)


def _record(run: Callable[[], GrindingRecord]) -> GrindingRecord | GrindError:
    try:
        return run()
    except GrindError as error:
        return error


def _record_events(record: GrindingRecord, examined: Examined) -> None:
    """Record the events of a run."""
    strokes = record.strokes
    table = strokes[strokes["groove"] == 0]
    p = record.job.parameters
    happened = {
        "spindle slows": (strokes["torque"] > SLOWED * p.rs).any() and bool((strokes["vs"] > 0.0).any()),
        "stall": (strokes["torque"] >= STALL).any(),
        "stall in a groove": (strokes["torque"][strokes["groove"] > 0] >= STALL).any(),
        "air": any(not (table["ae"][table["line"] == line] > 0.0).any() for line in np.unique(table["line"])),
        "several parts": len(record.parts) > 1,
        "stations met at once": _shares(record),
        "several stations ground": len({station.name for station in record.job.part_stations}) > 1,
        "dresses": len(record.dresses) > 0,
        "wheel destroyed": bool(strokes.size) and float(strokes["A"].max()) >= 0.999 * p.Amax,
    }
    examined.happened |= {name for name, true in happened.items() if true}


def _compare_tables(kind: str, found: Array, expected: Array, loosely: bool, examined: Examined) -> None:
    """Compare tables to the bit; `loosely` if the times of repeated dresses may differ in their last bits."""
    if found.shape != expected.shape:
        examined.differ(f"{kind}: number", found.shape, expected.shape)
        return
    for name in found.dtype.names or ():
        one, other = found[name], expected[name]
        same = np.array_equal(one, other)
        if not same and loosely and one.dtype == np.float64:
            same = bool(np.allclose(one, other, rtol=SUM, atol=1e-3 * SUM))
        if not same:
            k = int(np.flatnonzero(one != other)[0])
            examined.differ(f"{kind}: {name}", one[k].item(), other[k].item())
            return  # later differences follow from this one


def _replay(case: Case, examined: Examined, known: dict[str, Any]) -> bool:
    """Step the program block by block, also if some of its parts cannot be judged."""
    record = known.get("record")
    try:
        refuse_unjudged(known["programs"], case.job)
    except UnjudgedError as error:
        _require_sentence(error, examined)
        if record is None or not any(record.unjudged):
            examined.differ("replay: refuses parts that are judged", str(error)[:300], "judged")
    except JobError as error:
        if str(error) != known.get("refused"):
            examined.differ("replay: refused for its job", str(error)[:300], str(known.get("refused"))[:300])
        examined.replay = f"refused: {type(error).__name__}"
        return False
    else:
        if record is not None and any(record.unjudged):
            examined.differ("replay: grinds parts that are not judged", "judged", str(record.unjudged)[:300])
    if record is not None and _shares(record) and case.job.parts:
        # a run uses the conditions of all parts that strokes meet, a replay only those of parts at named stations
        examined.replay = "conditions of parts that share strokes"
        return False
    with patch.object(script, "refuse_unjudged"):
        return _replayed(case, examined, known)


def _replayed(case: Case, examined: Examined, known: dict[str, Any]) -> bool:
    """Step the program with its own E and D: compiled if it has a script, otherwise sometimes by the control."""
    programs, job, record = known["programs"], case.job, known.get("record")
    try:
        if case.seed % STEPPED_BY_CONTROL:
            script_of(programs, job)
    except ScriptError as why:
        _require_sentence(why, examined)
        examined.replay = _reason(str(why))
        return False
    except GrindError:
        pass  # the simulation has to refuse the program, too
    try:
        simulation = JobSimulation(programs, job, 0.0)
    except GrindError as error:
        _require_sentence(error, examined)
        if record is not None and not isinstance(error, JobProgramError | PassageError):
            examined.differ("replay: refuses a program that is ground", str(error)[:300], "ground")
        examined.replay = f"refused: {type(error).__name__}"
        return False
    if record is None:
        examined.replay = "ground"
        examined.differ("replay: grinds a program that is refused", "ground", known["refused"][:300])
        return False
    examined.replay = "script" if simulation.why is None else _reason(str(simulation.why))
    episode, wheels = ProgramEpisode(programs, job), []
    while episode.block is not None:
        mount, changes = episode.run.mount, episode.run.mount.changes
        episode.step({})
        # the own state is not comparable after a wheel change: a script counts the time until the unloading before it
        own = {} if mount.changes > changes else dict(zip(job.process.own._fields, mount.own[0].tolist(), strict=True))
        wheels.append({**mount.present(job.parameters)._asdict(), **own})
    _compare_tables("step: strokes", episode.run.record().strokes, record.strokes, True, examined)
    way = "control" if simulation.script is None else "replay"
    found = _stepped_blocks(simulation, [(block.plan.feed, block.plan.dresses) for block in simulation.blocks])
    if len(found.outcomes) != len(wheels):
        examined.differ(f"{way}: blocks", len(found.outcomes), len(wheels))
        return False
    _compare_wheels(way, simulation, found.wheels, wheels, examined)
    if any(record.unjudged):  # unjudged parts are charged as scrap
        return True
    _compare_sums(way, found, record, examined)
    if not _by_blocks(simulation, record):
        return True
    _compare_parts(way, simulation, found, record, examined)
    if simulation.script is not None:
        _compare_chosen(case, simulation, examined)
    return True


def _compare_chosen(case: Case, simulation: JobSimulation, examined: Examined) -> None:
    """Step the program with other E and D, and compare with the ground program that contains them."""
    rng, blocks = random.Random(case.seed), simulation.blocks
    by_line = {block.plan.line: (float(rng.randint(3000, 30_000)), rng.randint(0, 3)) for block in blocks}
    choices = [by_line[block.plan.line] for block in blocks]
    words = [simulation.words(number, *choice) for number, choice in enumerate(choices)]
    try:
        text = with_words_chosen(simulation.programs, list(zip((block.block for block in blocks), words, strict=True)))
        record = grind(read(text, NAME), case.job)
    except GrindError as error:
        _require_sentence(error, examined)  # a macro may set two blocks in one place
        return
    if any(record.unjudged):
        return
    found = _stepped_blocks(simulation, choices)
    last = simulation.tables.blocks[simulation.tables.blocks[:, ENDS_PART] > 0.0, FINISH]
    deepest = [record.strokes["Z"][record.strokes["part"] == part].max(initial=0.0) for part in record.parts["part"]]
    if len(last) != len(deepest) or not np.allclose(last, deepest, rtol=0.0, atol=SUM):
        return  # with another E, later infeeds meet other strokes
    _compare_sums("chosen", found, record, examined)
    if _by_blocks(simulation, record):
        _compare_parts("chosen", simulation, found, record, examined)


@dataclass(frozen=True, slots=True)
class Stepped:
    """Results of the blocks of a program."""

    outcomes: Array  # shape (blocks, fields of `Outcome`)
    tallies: Array  # shape (blocks, fields of `Tally`)
    wheels: Array  # wheel after each block with the own state of the process, shape (blocks, fields of both)

    def outcome(self, name: str) -> Array:
        """Return a column of the outcomes."""
        return self.outcomes[:, Outcome._fields.index(name)]

    def tally(self, name: str) -> Array:
        """Return a column of the tallies."""
        return self.tallies[:, Tally._fields.index(name)]


def _stepped_blocks(simulation: JobSimulation, choices: Sequence[tuple[float, int]]) -> Stepped:
    """Step the blocks with the chosen E, mm/min, and D."""
    episodes = simulation.start([np.random.default_rng(0)])
    rows: tuple[list[Array], list[Array], list[Array]] = [], [], []
    for E, D in choices:
        outcomes, tallies = simulation.step(episodes, np.array([E]), np.array([float(D)]))
        for each, new in zip(rows, (outcomes[0], tallies[0], episodes.wheels[0].copy()), strict=True):
            each.append(new)
    return Stepped(*(np.array(each) for each in rows))


def _compare_wheels(
    way: str, simulation: JobSimulation, found: Array, expected: Sequence[dict[str, float]], examined: Examined
) -> None:
    """Compare the wheels after each block, without the wear since gauging, which the ways count in different blocks.

    Wheels equal to the bit if the script has one zone and no stations, until an infeed during reciprocation, whose
    strokes depend on the clock. Otherwise sums are rounded differently. A block whose last stroke leads to the next
    block is left out: a script counts that stroke with the earlier block.
    """
    exact, compared, odd, by_clock = 0, 0, None, False
    script, stations = simulation.script, simulation.job.stations
    whole = script is not None and not stations and len(simulation.tables.zones) == 1
    for number, (one, other) in enumerate(zip(found.tolist(), expected, strict=True)):
        if script is not None:
            by_clock |= any(not isinstance(motion, Dwell) for motion in script.blocks[number].side_motions)
            if script.blocks[number].to_secondary:
                continue
        for here, (name, there) in zip(one, other.items(), strict=False):
            if name == "W":
                continue
            compared, exact = compared + 1, exact + (here == there)
            same = here == there if whole and not by_clock else _near(here, there)
            if odd is None and not same:
                odd = (f"{way}: wheel {name}", f"{here!r} in block {number}", there)
    examined.exact = exact, compared
    if odd is not None:
        examined.differ(*odd)


def _near(found: float, expected: float, absolute: float = 1e-12) -> bool:
    return found == expected or math.isclose(found, expected, rel_tol=SUM, abs_tol=absolute)


def _compare(kind: str, pairs: Mapping[str, tuple[float, float]], examined: Examined) -> None:
    for name, (found, expected) in pairs.items():
        if not _near(float(found), float(expected)):
            examined.differ(f"{kind} {name}", float(found), float(expected))


def _compare_sums(way: str, found: Stepped, record: GrindingRecord, examined: Examined) -> None:
    parts = record.parts
    costs = ("time_cost", "dress_cost") if _worn_away(record) else ("time_cost", "wheel_cost", "dress_cost")
    sums = {name: (found.outcome(name).sum(), parts[name].sum()) for name in costs}
    sums["seconds"] = found.outcome("seconds").sum(), record.seconds
    sums["good parts"] = found.outcome("good").sum(), parts["survival"].sum()
    for name, expected in (
        ("strokes", len(record.strokes)),
        ("dresses", len(record.dresses)),
        ("worn", parts["worn"].sum()),
        ("dressed_off", parts["dressed_off"].sum()),
    ):
        sums[name] = found.tally(name).sum(), expected
    _compare(f"{way}:", sums, examined)


def _worn_away(record: GrindingRecord) -> bool:
    """Return whether more than the whole wheel has worn off; the cost then depends on where a block begins."""
    parts = record.parts
    return bool((record.job.rates.wheel * (parts["worn"] + parts["dressed_off"]) > 1.0001 * parts["wheel_cost"]).any())


def _by_blocks(simulation: JobSimulation, record: GrindingRecord) -> bool:
    """Return whether each part is unloaded with its last block; the control may unload it during the next block."""
    finished = [(block.part, block.finished) for block in simulation.blocks]
    return [part for part, count in finished if count] == list(range(len(record.parts)))


def _compare_parts(
    way: str, simulation: JobSimulation, found: Stepped, record: GrindingRecord, examined: Examined
) -> None:
    """Compare the peaks and gauged values of each part."""
    finished, first = [block.finished for block in simulation.blocks], 0
    own = found.outcome("cost").sum() - found.outcome("handover_cost").sum()
    if not _worn_away(record):
        _compare(f"{way}:", {"cost": (own, record.parts["total_cost"].sum())}, examined)
    for part, number in enumerate(k for k, count in enumerate(finished) if count):
        row, blocks = record.parts[part], slice(first, number + 1)
        first = number + 1
        pairs = {
            "power": (found.outcome("peak_power")[blocks].max(), row["peak_power"]),
            "torque": (found.outcome("peak_torque")[blocks].max(), row["peak_torque"]),
            "burn ratio": (found.outcome("burn_ratio")[blocks].max(), row["burn_ratio"]),
            "Ra": (found.outcome("roughness")[number], row["Ra"]),
            "size error": (found.outcome("size_error")[number], row["worst_error"]),
            "survival": (found.outcome("good")[number], row["survival"]),
            "scrap cost": (found.outcome("scrap_cost")[number], row["scrap_cost"]),
        }
        if not record.stages[part]:
            pairs["temperature"] = (found.outcome("rise")[blocks].max(), row["rise"])
        _compare(f"{way}: part", pairs, examined)


def _reason(sentence: str) -> str:
    """Return the reason why there is no script, without place and numbers."""
    words = sentence.split("there is no script of this program: ")[-1].split(";")[0].split(",")[0]
    return "".join("#" if letter.isdigit() else letter for letter in words)


def _require_sentence(error: GrindError, examined: Examined) -> None:
    if "\n" in str(error) or not str(error):
        examined.findings.append(Finding("no sentence", repr(str(error))))
