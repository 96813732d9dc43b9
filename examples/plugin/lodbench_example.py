"""A metric, a method, a behaviour, and a representation: a fence whose posts are its parts."""

from dataclasses import dataclass

import numpy as np

from bench.methods.known_methods import culled_beyond
from bench.methods.method import Method, by_view
from lod.actors.object_with_parts import change
from lod.camera import GRID_M, Corner, camera_from_heading
from lod.hierarchy import Hierarchy
from lod.metric import Metric
from lod.pruner import BlendWeights, Parts
from lod.shapes import Sticks
from lod.view import View
from scenes.actors.acting import Acts, Me
from scenes.ground.relief import Ground
from scenes.plugins import RepresentationPlugin

HALFWAY = Metric("halfway", lambda P, R, m: P / m + 0.5 * R, "P > m·(d − R/2): between two of ours")

WOOD = np.array([[0.30, 0.20, 0.11]])
RADIUS_M, HEIGHT_M = 0.06, 1.2


@dataclass(frozen=True, eq=False)
class Fence:
    """Posts in a row to the east; from afar one beam, as high as they are close."""

    name: str
    ground: Ground
    posts: int = 12
    gap: float = 0.5

    @property
    def hierarchy(self) -> Hierarchy:
        """Row 0 the fence, every other row a post."""
        low, high = self.ground.bounds()
        reach = np.hypot(self.posts * self.gap / 2, high - low)
        one, n = HEIGHT_M / 2 + RADIUS_M, self.posts
        return Hierarchy(
            parent=np.r_[-1, np.zeros(n, np.int64)],
            level=np.r_[0, np.ones(n, np.int64)],
            position=np.zeros((n + 1, 3)),
            P=np.r_[np.sqrt(n * 2 * one * 2 * RADIUS_M), np.full(n, np.sqrt(4 * one * RADIUS_M))],
            R=np.r_[reach, np.full(n, one)],
            B=np.r_[reach + 2 * one, np.full(n, one)],
            separation=np.r_[0.0, np.full(n, reach)],
        )

    def roots(self, view: View) -> Parts:
        """The fence."""
        return self._parts(view, np.zeros(1, np.int64), np.full(1, -1))

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """The posts of every fence that is asked for."""
        whole = np.repeat(np.arange(len(parts)), np.where(parts.part == 0, self.posts, 0))
        number = np.arange(len(whole)) % self.posts
        return self._parts(view, number + 1, whole)

    def appearance(self, parts: Parts, weights: BlendWeights) -> Sticks:
        """Posts as they are; the fence itself as a beam, where it has to stand for them."""
        post = parts.part > 0
        share = np.where(post, weights.leaf + weights.inner, weights.leaf)
        rows = np.flatnonzero(share > 0)
        middle, post = parts.position[rows], post[rows]
        length = np.where(post, HEIGHT_M / 2, self.posts * self.gap / 2 - RADIUS_M)
        axis = np.where(post[:, None], (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)) * length[:, None]
        radius = RADIUS_M * np.minimum(share[rows], 1.0)
        return Sticks(middle - axis, middle + axis, radius, radius, np.zeros(len(rows)), WOOD, rows)

    def _parts(self, view: View, part: np.ndarray, whole: np.ndarray) -> Parts:
        position = self._middles(view.camera.corner)[part]
        tree, (inside, outside) = self.hierarchy, view.limits(self.hierarchy)
        return Parts(
            position=position,
            centre=position,
            bound=tree.B[part],
            limit=inside[part],
            limit_offscreen=outside[part],
            level=tree.level[part],
            object=np.zeros(len(part)),
            part=part,
            parent=whole,
            share=np.where(part > 0, 1 / self.posts, 1.0),
        )

    def _middles(self, corner: Corner) -> np.ndarray:
        x = (np.arange(self.posts) + 0.5) * self.gap - self.posts * self.gap / 2
        x = np.r_[0.0, x] - corner.x * GRID_M
        xy = np.column_stack((x, np.full(len(x), -corner.y * GRID_M)))
        return np.column_stack((xy, self.ground.height(corner, xy) + HEIGHT_M / 2))


FENCE = RepresentationPlugin(
    "a fence of posts (options: posts, gap)",
    lambda name, seed, ground, **options: Fence(name, ground, **options),
    camera_from_heading(Corner(0, 0), np.array((2.0, -6.0, 1.5)), 20.0, -5.0, 50.0, (120, 60)),
    detail=1.5,
)

NEAREST = Method(
    "nearest",
    "whole detail up to a few metres, nothing beyond",
    "a cheat",
    "distance [m]",
    (3.0, 2.0),
    by_view(culled_beyond),
)


def stroll(me: Me) -> Acts:
    """Go straight ahead (option: speed)."""
    while True:
        yield change(me.name, "go", me.option("speed", 1.0))
        yield None
