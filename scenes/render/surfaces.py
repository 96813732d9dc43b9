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
    """The shapes of a scene, and copies of models, which are instances named by their rows.

    joined  of copies, as of ``Copies.joined``, with the renderer's shapes
    """

    def __init__(
        self, scene: Any, copies: Copies | None = None, joined: Sequence[Any] = ((), None, None)
    ) -> None:
        shapes = scene.shapes()
        self._copied, where, self.owners = joined
        self._glow = any(shape.emitter() for shape in shapes if not copies)
        if not copies:
            return
        numbers = np.array(dr.reinterpret_array(mi.UInt32, scene.shapes_dr())).astype(np.int64)
        copy = np.array([int(s.id()) if s.class_name() == "Instance" else -1 for s in shapes])
        is_one, alone = copy >= 0, [shapes[k] for k in np.flatnonzero(copy < 0)]
        self.copy = np.full(int(numbers.max()) + 1, -1)
        """Row of the copy of each number of the renderer's, -1 of other shapes."""
        self.copy[numbers[is_one]] = copy[is_one]
        # Where in ``_targets`` a shape is; of a copy, where in ``where`` its model's shapes begin.
        target = np.zeros(len(self.copy), np.uint32)
        target[numbers[~is_one]] = np.arange(len(alone))
        first = np.cumsum([0, *map(len, copies.models)])
        target[numbers[is_one]] = first[copies.which[copy[is_one]]]
        self._target, self._row = mi.UInt32(target), mi.UInt32(np.maximum(self.copy, 0))
        self._place = mi.Float(copies.place.astype(np.float32).reshape(-1))
        self._turn = mi.Float(copies.turn.astype(np.float32).reshape(-1))
        where = where + np.array([len(alone), 0, 0])
        self._joined, self._first, self._first_of_all = map(mi.UInt32, where.T.copy())
        targets = [*alone, *self._copied]
        self._glow = any(shape.emitter() for shape in targets)
        self._targets = [_completed(shape, self._glow) for shape in targets]
        sides = (mi.has_flag(each.bsdf().flags(), mi.BSDFFlags.BackSide) for each in targets)
        self._has_back = mi.UInt32(list(map(int, sides)))

    def complete(self, ray: Any, hit: Any, active: Any) -> Met:
        """Complete hits of active rays that the scene's ``ray_intersect_preliminary`` found."""
        if not self._copied:  # the renderer's own calls are a tenth faster
            si = hit.compute_surface_interaction(ray, mi.RayFlags.ShadingFrame, active)
            bsdf, number = si.bsdf(), dr.reinterpret_array(mi.UInt32, si.shape)
            back, null = mi.BSDFFlags.BackSide, mi.BSDFFlags.Null
            both, none = (mi.has_flag(bsdf.flags(), flag) for flag in (back, null))
            albedo = bsdf.eval_diffuse_reflectance(si, active)
            emitted = si.shape.emitter().eval(si, active) if self._glow else None
            return Met(si, number, albedo, emitted, both | (si.wi.z > 0), none)
        valid = active & hit.is_valid()
        instance: Any = dr.reinterpret_array(mi.UInt32, hit.instance)
        on_one = valid & (instance > 0)
        number = dr.select(on_one, instance, dr.reinterpret_array(mi.UInt32, hit.shape))
        row = dr.gather(mi.UInt32, self._row, number, on_one)
        place = dr.gather(mi.Point3f, self._place, row, on_one)
        turn = dr.gather(mi.Vector2f, self._turn, row, on_one)
        cos, sin = dr.select(on_one, turn.x, 1.0), turn.y
        o, d = (_turned(v, cos, -sin) for v in (ray.o - place, ray.d))
        target: Any = dr.gather(mi.UInt32, self._target, number, valid)
        shape = target + hit.shape_index
        target[on_one] = dr.gather(mi.UInt32, self._joined, shape, on_one)
        own, prim = (
            hit.prim_index + dr.gather(mi.UInt32, first, shape, on_one)
            for first in (self._first, self._first_of_all)
        )
        asked = o, d, hit.t, own, hit.prim_uv, valid
        p, n, shading, albedo, emitted = dr.switch(target, self._targets, *asked)
        si = dr.zeros(mi.SurfaceInteraction3f, dr.width(valid))
        si.t, si.time = dr.select(valid, hit.t, dr.inf), ray.time
        si.p, si.n = _turned(p, cos, sin) + place, _turned(n, cos, sin)
        si.sh_frame = mi.Frame3f(_turned(shading, cos, sin))
        si.wi, si.prim_index, si.shape = si.to_local(-ray.d), prim, hit.shape
        both = dr.gather(mi.UInt32, self._has_back, target, valid) > 0
        return Met(si, number, albedo, emitted, both | (si.wi.z > 0), mi.Bool(False))


def _turned(vector: Any, cos: Any, sin: Any) -> Any:
    x, y = cos * vector.x - sin * vector.y, sin * vector.x + cos * vector.y
    return type(vector)(x, y, vector.z)


def _completed(shape: Any, glow: bool) -> Callable[..., tuple[Any, ...]]:
    """A function that completes hits on a shape in its own coordinates; ``glow`` if any emits."""
    bsdf, emitter = shape.bsdf(), shape.emitter()

    def complete(o: Any, d: Any, t: Any, prim: Any, uv: Any, active: Any) -> tuple[Any, ...]:
        hit = dr.zeros(mi.PreliminaryIntersection3f, dr.width(t))
        hit.t, hit.prim_index, hit.prim_uv = t, prim, uv
        ray = mi.Ray3f(o, d)
        si = shape.compute_surface_interaction(ray, hit, mi.RayFlags.ShadingFrame, active)
        si.prim_index, si.shape = prim, mi.ShapePtr(shape)
        si.wi = si.to_local(-d)
        emitted = mi.Color3f(0.0) if glow else None
        if emitter:
            emitted = emitter.eval(si, active)
        albedo = bsdf.eval_diffuse_reflectance(si, active)
        return si.p, si.n, si.sh_frame.n, albedo, emitted

    return complete
