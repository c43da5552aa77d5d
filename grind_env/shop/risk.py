"""What may be risked with other words: that a part takes more with them than with the program as it is."""

import numpy as np

from grind_env.arrays import Array
from grind_env.machine.job import Job
from grind_env.shop.trials import Measures, Trials

CALIBRATED, UNCALIBRATED = 1.05, 1.2
"""What a part may take with other words at most, over what it takes in the mean, on a machine where they are bad; the
second one without a calibration, when machines may be so unlike that hardly any words are no risk on one in twenty."""


def most_risk(job: Job) -> float:
    """What may be risked on the machines of a job."""
    return UNCALIBRATED if job.uncertainty is None else CALIBRATED


def risk(trials: Trials, found: Measures, old: Measures, quantity: str = "cost") -> Array:
    """What a part takes over that with the program as it is, `old`, of C candidates, shape (C,).

    On a machine for which this is as high as the confidence allows.
    """
    less, before = (trials.by_machine(getattr(each, quantity)) for each in (found, old))
    return np.asarray(np.quantile(less / before[0], trials.confidence, axis=1))
