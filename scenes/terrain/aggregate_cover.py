"""What the ground asks of the cover that undisplayed objects leave on it (``scenes.far_cover``)."""

from typing import Protocol, runtime_checkable

from lod.arrays import Points, Reals
from lod.view import View


@runtime_checkable
class ResidualCover(Protocol):
    """Cover that undisplayed objects leave at n points of the ground, as the eye sees it."""

    @property
    def lift(self) -> Reals:
        """Height by which the cover raises the ground, (n,) [m]."""

    @property
    def covered(self) -> Reals:
        """Share of the ground that the cover hides from the eye, (n,)."""

    def colours(self, normals: Points, bare: Points) -> Points:
        """Albedo of the covered ground, (n, 3).

        normals, bare (n, 3)  of the ground without its small bumps, and its own albedo
        """


@runtime_checkable
class AggregateCover(Protocol):
    """Species whose undisplayed objects leave their cover, colour and height on the ground."""

    @property
    def highest(self) -> float:
        """Largest height by which the cover can raise the ground [m]."""

    def residual(self, view: View, points: Points) -> ResidualCover:
        """What the species leave at points (n, 3) of the ground in a view."""
