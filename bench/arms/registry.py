"""Which arms are there? Those of this package, and those of other packages by entry point.

A package names its arms (``bench.arms.arm.Arm``) in the group ``lodbench.arms``.
"""

from bench.arms.arm import Arm
from bench.arms.discrete_levels import DISCRETE
from bench.arms.plain_arms import DISTANCE, EVERYTHING, IN_VIEW, metric_arm
from bench.arms.stochastic import STOCHASTIC
from lod.errors import InputError
from scenes.plugins.entry_points import installed, load_entry

ARMS = "lodbench.arms"

OURS: dict[str, Arm] = {
    arm.name: arm
    for arm in (
        *map(metric_arm, ("blake", "bounded", "solid_angle", "depth")),
        EVERYTHING,
        DISCRETE,
        STOCHASTIC,
        DISTANCE,
        IN_VIEW,
    )
}
"""The arms of this package by name; ``full`` is what the others are compared with."""


def arms() -> dict[str, Arm]:
    """Return every arm by name, this package's first.

    Raises InputError for an installed arm that cannot be imported, and for one of a taken name.
    """
    found = dict(OURS)
    for name in installed(ARMS):
        if name in found:
            raise InputError(f"{ARMS} {name}", name, "a name that no arm has", "rename the arm")
        found[name] = load_entry(ARMS, name, Arm)
    return found
