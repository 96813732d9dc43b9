"""Metrics of another package that break the rules; its entry points name what does not exist."""

import numpy as np

from lod.metric import Metric

SLOPPY = Metric("sloppy", lambda P, R, m: P * R.max() / m, "a metric that looks at all parts")
OFTEN_NAN = Metric("often_nan", lambda P, R, m: np.sqrt(P - 1.0), "limits that are no numbers")
