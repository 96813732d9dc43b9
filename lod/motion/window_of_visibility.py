"""The window of visibility: what moves too fast for an eye that does not follow it (§5.2).

Of everything on a display the eye sees what lies below a limit in time, ω_l, and one in space, u_l,
and next to nothing beyond either (Watson & Ahumada, "A look at motion in the frequency domain",
NASA TM 84352, 1983; Watson, Ahumada & Farrell, "The window of visibility", NASA TP 2211, 1983). A
grating of frequency u that passes at r has r·u periods a second: it is out of the window from
u = ω_l/r on. A feature of size a is half a period of u = 1/(2a), so what is smaller than
r/(2·ω_l) is gone along its path, as if a shutter had been open for 1/(2·ω_l).
"""

import math

from lod.arrays import Reals

LIMIT_HZ = 30.0
"""ω_l, the round figure of both papers."""


def integration_time_s(shutter_s: float, limit_hz: float = LIMIT_HZ) -> float:
    """Compute how long an eye behind a shutter integrates [s]: variances of both add (§2.1)."""
    return math.hypot(shutter_s, 1 / (2 * limit_hz))


def critical_hz(speed_deg_s: Reals, finest_cpd: float, limit_hz: float = LIMIT_HZ) -> Reals:
    """Compute the update rate ω_c = ω_l + r·u_l (1983) above which motion looks smooth, (n,) [Hz].

    The copies that sampling makes of its spectrum then lie outside the window; u_l in cycles per
    degree.
    """
    return limit_hz + speed_deg_s * finest_cpd
