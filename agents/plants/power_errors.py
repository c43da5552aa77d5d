"""Errors of predicted power on other cuts: after a calibration, after a regression, and by the catalogue."""

import math
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from agents.plants.program_variants import scaled
from agents.plants.shop_log import Logged, logged
from agents.plants.study_machines import StudyMachine
from grind_env.array_types import Array
from grind_env.control import Programs, read_file
from grind_env.envs.job.repeated_program import repeated
from grind_env.errors import GrindError
from grind_env.machine.grind import grind
from grind_env.machine.job import Job
from grind_env.machine.job.job_file import load_job
from grind_env.shop.calibrate.log_calibration import calibrate
from grind_env.shop.calibrate.result import Calibration

#: volume added to V' in the regression, mm3/mm; depth, mm, below which nothing is cut; weight, over all rows, of the
#: prior for terms that no row determines: power goes with the removal rate, to the power .8, and not with the volume
EARLY, LEAST, WEAK = 10.0, 1e-5, 1e-3
TO_A_CHIP = np.array([[0.0, 1.0, -1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]]), np.array([0.0, 0.0, 0.8])


class MeanCuts(NamedTuple):
    """Cuts of each stroke, or means over several strokes, shape (n,); `fitted` explains the symbols."""

    a: Array
    v: Array
    V: Array
    b: Array

    @property
    def terms(self) -> Array:
        """Columns of the regression."""
        depth = np.maximum(self.a, LEAST)
        return np.column_stack([np.ones(len(depth)), np.log(depth), np.log(self.v), np.log(self.V + EARLY)])


def fitted(cuts: MeanCuts, power: Array) -> Array:
    """Return the regression of a shop without a model: log P/b = c + e log a + f log v + g log(V' + 10).

    Depth of cut a, mm, width b, mm, and volume V', mm3/mm, come from the machine of the catalogue; a shop knows less. v
    is the programmed table speed, mm/s. `power` is in W; strong strokes count more than weak strokes.
    """
    usable = (power > 0.0) & (cuts.a > LEAST) & (cuts.b > 0.0)
    some = MeanCuts(*(each[usable] for each in cuts))
    held = WEAK * float(power[usable].sum())
    rows = np.vstack([power[usable, None] * some.terms, held * TO_A_CHIP[0]])
    goal = np.append(power[usable] * np.log(power[usable] / some.b), held * TO_A_CHIP[1])
    return np.asarray(np.linalg.lstsq(rows, goal, rcond=None)[0])


def predicted(coefficients: Array, cuts: MeanCuts) -> Array:
    """Return the power, W; 0 where nothing is cut."""
    return np.where(cuts.a > LEAST, cuts.b * np.exp(cuts.terms @ coefficients), 0.0)


#: predicted cuts: factors on E and on picks, and whether there are dresses; the logs have E times 0.8 to 1.2
OTHERS = ((1.0, 1.0, True), (0.6, 1.0, True), (1.5, 1.0, True), (1.0, 0.5, True), (1.0, 1.6, True), (1.3, 1.4, False))


def answer(machine: StudyMachine, *_: object) -> dict[str, float]:
    """Return the mean errors of the power of blocks, or `refused` alone if the calibration refuses the log."""
    with tempfile.TemporaryDirectory() as folder:
        log = logged(machine, Path(folder))
        try:
            found = calibrate(log.log, log.program, log.job, gauge=log.gauge)
        except GrindError:
            return {"refused": 1.0}
        return errors(machine, log, found)


def errors(machine: StudyMachine, log: Logged, found: Calibration) -> dict[str, float]:
    """Return the mean of |log| of predicted over metered power of the blocks of other programs."""
    catalogue, truth, program = load_job(log.job), machine.job(), machine.program
    coefficients = _regression(found, read_file(log.program), catalogue)
    shown = math.exp(found.fit.scales.get("power", 0.0))
    rows = []
    for E, J, dressed in OTHERS:
        programs = program.read(scaled(program.text, E, J, dressed=dressed))
        block, real = _strokes(programs, truth)
        goal = log.gain * _means(block, real["power"])
        plain, fit = _strokes(programs, catalogue)[1], _strokes(programs, found.fitted)[1]
        guesses = shown * fit["power"], predicted(coefficients, _cuts(plain)), plain["power"]
        rows.append([np.abs(np.log(np.maximum(_means(block, guess), 1.0) / goal)).mean() for guess in guesses])
    return dict(zip(("error", "regression", "catalogue"), np.mean(rows, axis=0).tolist(), strict=True))


def _regression(found: Calibration, programs: Programs, catalogue: Job) -> Array:
    """Return the regression on the calibration's rows, whose log may have several runs of the program."""
    assert found.seen is not None
    weights, once = found.seen.weights, _strokes(programs, catalogue)[1]
    nominal = _strokes(repeated(programs, weights.shape[1] // len(once)), catalogue)[1]
    power = found.data.value[found.data.kind == "power"]
    return fitted(MeanCuts(*(weights @ each for each in _cuts(nominal))), power)


def _strokes(programs: Programs, job: Job) -> tuple[Any, Any]:
    """Return for each stroke the number of its block, and its row."""
    strokes = grind(programs, job).strokes
    strokes = strokes[strokes["groove"] == 0]
    _, block = np.unique(strokes["line"], return_inverse=True)
    return block, strokes


def _cuts(strokes: Any) -> MeanCuts:
    return MeanCuts(strokes["ae"], strokes["E"] / 60.0, strokes["V"], strokes["b"])


def _means(block: Any, power: Array) -> Array:
    return np.asarray(np.bincount(block, power) / np.bincount(block))
