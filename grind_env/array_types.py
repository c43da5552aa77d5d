"""Types of arrays."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Table = NDArray[np.float64]  #: array with one row for each machine, episode or lot
Numbers = NDArray[np.int64]
Floats = NDArray[np.float64]
