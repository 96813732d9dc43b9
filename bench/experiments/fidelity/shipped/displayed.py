"""What is displayed where the ground and all else each have a detail of their own?

The ground carries the colour of what stands beyond its limit (the far cover), so it is always given
the detail of what stands on it: nothing is then in the picture twice, and nothing is missing.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from lod.arrays import Points
from lod.metric import Metric
from lod.pruner import prune
from lod.shapes import Sticks, batches_of
from lod.view import View
from scenes.frame.frame_input import DisplayedRepresentation, Quality, display
from scenes.ground.shading import AggregateCover, ResidualCover
from scenes.render.memory import predict_bytes
from scenes.world.world import World

Shown = tuple[DisplayedRepresentation, ...]

FINEST = 1 / 16
"""The finest detail of a reference that is tried [px]."""


@dataclass(frozen=True)
class CoverOf:
    """The cover that is left on the ground by objects with a detail [px] and a metric of their own.

    It is an AggregateCover of ``scenes.ground``.
    """

    cover: AggregateCover
    detail: float
    metric: Metric

    @property
    def highest(self) -> float:
        """Largest height by which the cover can raise the ground [m]."""
        return self.cover.highest

    def residual(self, view: View, points: Points) -> ResidualCover:
        """Return what is left at points (n, 3) of the ground of a view, however that is pruned."""
        return self.cover.residual(replace(view, detail=self.detail, metric=self.metric), points)


def display_ground(
    world: World,
    view: View,
    detail: float,
    of_others: float,
    metric_of_others: Metric | None = None,
) -> Shown:
    """Display the ground at a detail [px], under the cover of what is pruned at ``of_others``.

    That is pruned by the view's metric unless it has another.
    """
    terrain, cover = world.terrain, world.terrain.aggregate_cover
    if cover is not None:
        terrain = replace(
            terrain, aggregate_cover=CoverOf(cover, of_others, metric_of_others or view.metric)
        )
    at = replace(view, detail=detail)
    return (display(terrain, prune(terrain, at), at),)


def display_others(world: World, view: View, detail: float) -> Shown:
    """Display all but the ground at a detail [px]."""
    at = replace(view, detail=detail)
    others = (each for each in world.representations if each is not world.terrain)
    return tuple(display(each, prune(each, at), at) for each in others)


def reference_detail(
    world: World, view: View, shown: Shown, quality: Quality, most: int
) -> tuple[float, int]:
    """Find the finest detail [px] of a frame that is predicted to need at most so many bytes.

    ``shown`` is what the view displays at its own detail: sticks and triangles are predicted to
    grow as the parts do. Gives the detail, and the bytes predicted for it.
    """
    size = view.camera.width, view.camera.height

    def bytes_at(detail: float) -> int:
        at, sticks, triangles = replace(view, detail=detail), 0.0, 0.0
        for each, one in zip(world.representations, shown, strict=True):
            grown = len(prune(each, at)) / max(len(one.cut), 1)
            for shape in batches_of(one.shape):
                if isinstance(shape, Sticks):
                    sticks += len(shape) * grown
                else:
                    triangles += len(shape) * grown
        return predict_bytes(round(sticks), round(triangles), size, quality)

    return finest_within(bytes_at, view.detail, most)


def finest_within(bytes_at: Callable[[float], int], start: float, most: int) -> tuple[float, int]:
    """Halve a detail again and again while it is predicted to fit into ``most`` bytes.

    Gives the finest that fits (``start`` itself is not judged) and its bytes. Details below FINEST
    are not tried, nor one that would not fit if bytes grew as at the halving before: even to count
    what it displays takes memory.
    """
    detail, need, growth = start, bytes_at(start), 1.0
    while detail / 2 >= FINEST and need * growth <= most:
        then = bytes_at(detail / 2)
        if then > most:
            break
        detail, need, growth = detail / 2, then, then / need
    return detail, need
