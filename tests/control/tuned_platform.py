"""A platform whose loop is tuned."""

import numpy as np

from rwjax.control.controller import LoopTiming
from tests.systems import platform

REFERENCE, TIMING = np.full(300, 0.3), LoopTiming()
RIG = platform()
