"""One kind of thing that is a table: its anatomy, its size and colours, its way of moving."""

from dataclasses import dataclass

from scenes.gait.gait import Gait
from scenes.rig.anatomy import Anatomy, Build, Limits


@dataclass(frozen=True)
class Kind:
    """Everything that tells one kind from another."""

    anatomy: Anatomy
    build: Build
    gait: Gait


def hinge(low: float, high: float) -> Limits:
    """A joint that turns about y alone, from low to high degrees."""
    return (0.0, low, 0.0), (0.0, high, 0.0)


def free(x: float, y: float, z: float) -> Limits:
    """A joint that turns by as many degrees to either side."""
    return (-x, -y, -z), (x, y, z)
