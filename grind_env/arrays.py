"""Types of arrays."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Table = NDArray[np.float64]
"""One row a machine, an episode or a lot."""
Numbers = NDArray[np.int64]
