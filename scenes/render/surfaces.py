"""What rays meet in a JIT variant, and what it is like there.

The renderer completes a hit on an instance by calls to every shape there is from within each
instance, which takes N². Here the shape itself completes it, in its own coordinates, and tables
give the model that an instance shares, where it stands and how it is turned.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.render.description import Copies


class Met(NamedTuple):
    """What rays met: nothing where ``si`` is not valid.

    si        the hit in the world's coordinates
    number    the renderer's number of the shape or of the copy; primitives of all models are
              numbered together
    albedo    diffuse reflectance
    emitted   radiance that the surface itself sends back along the ray
    reflects  whether that side of the surface reflects light
    bends_none  whether it lets light through as if it were not there
    """

    si: Any
    number: Any
    albedo: Any
    emitted: Any
    reflects: Any
    bends_none: Any


class Surfaces:
    """The shapes of a scene, and copies, named by their rows, that share those of ``models``."""

    def __init__(
        self, scene: Any, copies: Copies | None = None, joined: Sequence[Any] = ((), None, None)
    ) -> None:
        self.scene = scene
        self._copied, where, self.owners = joined
        shapes = scene.shapes()
        numbers = np.array(dr.reinterpret_array(mi.UInt32, scene.shapes_dr())).astype(np.int64)
        target = np.zeros(int(numbers.max(initial=0)) + 1, np.uint32)
        self.instance = np.zeros(len(target), np.uint32)
        """One more than the row of the copy of each number, 0 of other shapes."""
        if copies:
            ids = [int(s.id()) if s.class_name() == "Instance" else -1 for s in shapes]
            rows = np.array(ids)
            one = rows >= 0
            # Of a copy the first of its model's shapes in ``where``.
            first = np.cumsum([0, *map(len, copies.models)])
            target[numbers[one]] = first[copies.which[rows[one]]]
            self.instance[numbers[one]] = 1 + rows[one]
            numbers, shapes = numbers[~one], [shapes[k] for k in np.flatnonzero(~one)]
            self._row = mi.UInt32(np.maximum(self.instance, 1) - 1)
            self._place = mi.Float(copies.place.astype(np.float32).reshape(-1))
            self._turn = mi.Float(copies.turn.astype(np.float32).reshape(-1))
            self._joined, self._first, self._first_of_all = map(mi.UInt32, where.T.copy())
        target[numbers] = np.arange(len(shapes))
        self._target, self._alone = mi.UInt32(target), len(shapes)
        self._targets = [_completed(shape) for shape in (*shapes, *self._copied)]

    def find(self, ray: Any, coherent: bool, active: Any) -> Any:
        """Find what rays meet first, to be completed where they are ``active``."""
        return self.scene.ray_intersect_preliminary(ray, coherent=coherent, active=active)

    def hides(self, ray: Any, active: Any) -> Any:
        """Tell whether rays meet anything."""
        return self.scene.ray_test(ray, active)

    def complete(self, ray: Any, hit: Any, active: Any) -> Met:
        """Complete hits of active rays that ``find`` found."""
        valid = active & hit.is_valid()
        number: Any = dr.reinterpret_array(mi.UInt32, hit.shape)
        local, prim, own = mi.Ray3f(ray), mi.UInt32(hit.prim_index), mi.UInt32(hit.prim_index)
        if self._copied:
            instance: Any = dr.reinterpret_array(mi.UInt32, hit.instance)
            on_one = valid & (instance > 0)
            number = dr.select(on_one, instance, number)
            row = dr.gather(mi.UInt32, self._row, number, on_one)
            place = dr.gather(mi.Point3f, self._place, row, on_one)
            turn = dr.gather(mi.Vector2f, self._turn, row, on_one)
            cos, sin = dr.select(on_one, turn.x, 1.0), turn.y
            local.o, local.d = (_turned(v, cos, -sin) for v in (ray.o - place, ray.d))
        target: Any = dr.gather(mi.UInt32, self._target, number, valid)
        if self._copied:
            shape = target + hit.shape_index
            target[on_one] = self._alone + dr.gather(mi.UInt32, self._joined, shape, on_one)
            own += dr.gather(mi.UInt32, self._first, shape, on_one)
            prim += dr.gather(mi.UInt32, self._first_of_all, shape, on_one)
        asked = local.o, local.d, hit.t, own, hit.prim_uv
        p, n, shading, *about = dr.switch(target, self._targets, *asked, valid)
        if self._copied:
            p, n, shading = (_turned(v, cos, sin) for v in (p, n, shading))
            p += place
        si = dr.zeros(mi.SurfaceInteraction3f, dr.width(valid))
        si.t = dr.select(valid, hit.t, dr.inf)
        si.p, si.n, si.sh_frame = p, n, mi.Frame3f(shading)
        si.wi, si.time = si.to_local(-ray.d), ray.time
        si.prim_index, si.shape = prim, hit.shape
        return Met(si, number, *about)


def _turned(vector: Any, cos: Any, sin: Any) -> Any:
    x, y = cos * vector.x - sin * vector.y, sin * vector.x + cos * vector.y
    return type(vector)(x, y, vector.z)


def _completed(shape: Any) -> Callable[..., tuple[Any, ...]]:
    """A function that completes hits on a shape in its own coordinates."""
    bsdf, emitter = shape.bsdf(), shape.emitter()
    both, none = (
        mi.has_flag(bsdf.flags(), flag) for flag in (mi.BSDFFlags.BackSide, mi.BSDFFlags.Null)
    )

    def complete(o: Any, d: Any, t: Any, prim: Any, uv: Any, active: Any) -> tuple[Any, ...]:
        hit = dr.zeros(mi.PreliminaryIntersection3f, dr.width(t))
        hit.t, hit.prim_index, hit.prim_uv = t, prim, uv
        ray = mi.Ray3f(o, d)
        si = shape.compute_surface_interaction(ray, hit, mi.RayFlags.ShadingFrame, active)
        si.prim_index, si.shape = prim, mi.ShapePtr(shape)
        si.wi = si.to_local(-d)
        emitted = emitter.eval(si, active) if emitter else mi.Color3f(0.0)
        albedo = bsdf.eval_diffuse_reflectance(si, active)
        return (si.p, si.n, si.sh_frame.n, albedo, emitted, (si.wi.z > 0) | both, mi.Bool(none))

    return complete
