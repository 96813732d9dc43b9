"""From a plain description to a Mitsuba scene and its cameras, in whatever variant is set.

The renderer has no camera that sees all round: ``PanoramaSensor`` is one, equirectangular.
"""

import gc
import math
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from weakref import WeakSet

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.render.built_shapes import (
    file_shape,
    instance_plugins,
    make_shape,
    reach_of,
    stabilise_kernels,
)
from scenes.render.description import MEDIUM, Copies, Description
from scenes.render.light import load_plugin, sky, sun, variant_bands
from scenes.render.surfaces import Surfaces


class PanoramaSensor:
    """Rays of a panorama, by the calls that drivers make of the renderer's sensors."""

    def __init__(self, camera: Description) -> None:
        self._camera = camera

    def needs_aperture_sample(self) -> bool:
        """Tell that rays start in one point."""
        return False

    def sample_ray_differential(
        self, time: Any, wavelength: Any, film: Any, aperture: Any
    ) -> tuple[Any, float]:
        """Make rays through points of the film, from (0, 0) in the upper left to (1, 1)."""
        eye, forward, up = (self._camera[name] for name in ("eye", "forward", "up"))
        axes = [_opaque(axis) for axis in (np.cross(forward, up), forward, up)]
        turn, rise = (film.x - 0.5) * (2 * math.pi), (0.5 - film.y) * math.pi
        (sine, cosine), (high, level) = dr.sincos(turn), dr.sincos(rise)
        ahead = axes[0] * (level * sine) + axes[1] * (level * cosine)
        direction = dr.normalize(ahead + axes[2] * high)
        near, far = self._camera["clip"]
        start = mi.Point3f(_opaque(eye)) + direction * near
        ray = mi.Ray3f(start, direction, time)
        ray.maxt = far - near
        return mi.RayDifferential3f(ray), 1.0


def _opaque(values: np.ndarray) -> Any:
    """Make a vector an input of the kernel, which is so not compiled anew for another one."""
    return mi.Vector3f([dr.opaque(mi.Float, float(value)) for value in values])


GUIDES = {
    "depth": slice(0, 1),
    "sh_normal": slice(1, 4),
    "albedo": slice(4, 7),
    "shape_index": slice(7, 8),
    "prim_index": slice(8, 9),
    "position": slice(9, 12),
}
"""What is known of a hit beside its colour, and in which channels; position for motion only."""

ORDERS = 64
"""Edges of a path through a medium, bounces and scatterings together."""

BLOCK_SIZE = 32
"""Fixed, because Mitsuba derives it from the thread count otherwise, and the noise from it."""


@dataclass(frozen=True, eq=False)
class BuiltScene:
    """A Mitsuba scene, and what finds its way back from a hit to the parts.

    integrators   "image" alone, "distance" alone, "guides" alone, and "all": image and guides;
        "medium": the image with what its medium does to it
    description  of the frame, without the arrays of what does not move
    names  of the shapes by the renderer's shape number; "" is none, as 0, the sky
    ids    (n, 3) uint32 object, part and level of every displayed part; row 0 is the sky
    owners row of ``ids`` of each primitive, by the renderer's shape number; of what has none, none
    medium that the eye is in, None in clear air and where haze is worked out after the fact
    surfaces  in JIT variants, what rays meet
    copies  copies of models, whose parts ``surfaces`` tells
    """

    scene: Any
    description: Description
    integrators: dict[str, Any]
    names: tuple[str, ...]
    ids: np.ndarray
    owners: tuple[np.ndarray, ...]
    medium: Any = None
    surfaces: Any = None
    copies: Copies = field(default_factory=Copies)

    def hit_ids(self, shape: np.ndarray, prim: np.ndarray) -> np.ndarray:
        """Object, part and level of hits given the renderer's shape and primitive numbers."""
        row = np.zeros(shape.shape, np.uint32)
        for number, owners in enumerate(self.owners):
            if len(owners):
                hit = shape == number
                row[hit] = owners[prim[hit].astype(np.int64)]
        if not len(self.copies):
            return self.ids[row]
        copy = self.surfaces.copy[shape.astype(np.int64)]
        hit = copy >= 0
        row[hit] = self.surfaces.owners[prim[hit].astype(np.int64)]
        found = self.ids[row]
        found[hit, 0] = self.copies.object[copy[hit]]
        return found


_ALIVE: WeakSet[BuiltScene] = WeakSet()
"""Scenes that have not been freed. Where only a reference cycle holds one, as after the imports of
a first frame, it is collected before the next is built: a JIT variant compiles code for every shape
that exists. Collecting takes time, so it is done only where a scene is left."""


def build_scene(description: Description) -> BuiltScene:
    """Build the scene of a description, acceleration structure included, and use it up.

    Its ``shapes``, ``ids`` and ``owners`` move into the scene, which halves peak memory: do not use
    the description afterwards.
    """
    if _ALIVE:
        gc.collect()
    shapes, ids, owners = (description.pop(name) for name in ("shapes", "ids", "owners"))
    copies: Copies = description.pop("copies")
    moving = {name: shapes[name] for name in description["moves"]}
    medium, contents = None, {}
    scalar = str(mi.variant()).startswith("scalar_")
    light = description["light"]
    lights = {"sky": sky(light, sun_scale=0.0), "sun": sun(light)}
    if box := description.get(MEDIUM):
        contents[MEDIUM] = _box(box)
        medium = contents[MEDIUM].interior_medium()
    with tempfile.TemporaryDirectory() as folder:
        stub = Path(folder) / "stub.txt"
        stub.write_text("0 0 0 1\n0 0 1 1\n")
        models = [[make_shape("model", s, stub) for s, _ in own] for own in copies.models]
        shapes_of_all, where, of_all = copies.joined()
        joined = [make_shape("models", each, stub) for each in shapes_of_all], where, of_all
        left = stabilise_kernels(shapes, reach_of(copies))
        del shapes
        for name in list(left):
            shape = left.pop(name)
            contents[name] = (
                file_shape(name, shape, Path(folder)) if scalar else make_shape(name, shape, stub)
            )
        placed = instance_plugins(copies, models)
        scene = load_plugin({"type": "scene", **lights, **contents, **placed})
    names, surfaces = ["", *contents], None
    if not scalar:
        # A JIT variant numbers all shapes that there are, those of other scenes as well.
        numbers = np.array(dr.reinterpret_array(mi.UInt32, scene.shapes_dr())).tolist()
        found = dict(zip(numbers, [shape.id() for shape in scene.shapes()], strict=True))
        names = [found.get(number, "") for number in range(max(found) + 1)]
        surfaces = Surfaces(scene, copies, joined)
    owned = tuple(owners.get(name, np.zeros(0, np.uint32)) for name in names)
    kept, integrators = {**description, "shapes": moving}, _integrators(description)
    known = scene, kept, integrators, tuple(names), ids, owned, medium
    _ALIVE.add(built := BuiltScene(*known, surfaces, copies))
    return built


def sensor(
    camera: Description,
    side: int = 1,
    rows: tuple[int, int] | None = None,
    spp: int = 1,
    medium: Any = None,
    spectrum: bool = False,
) -> Any:
    """Make the camera with a film of ``side`` by ``side`` pixels to each pixel, of these ``rows``.

    ``rows`` are the first and one past the last, from the top; None: all. ``medium`` is what the
    eye is in. With ``spectrum`` the film has a channel for each band of a spectral variant. Rays
    start all over the opening of the lens where the camera has one (``pinhole`` takes it away).
    """
    if camera["panorama"]:
        return PanoramaSensor(camera)
    width, height = (side * pixels for pixels in camera["size"])
    top, bottom = rows or (0, height)
    eye, forward, up = (camera[name].tolist() for name in ("eye", "forward", "up"))
    target = [e + f for e, f in zip(eye, forward, strict=True)]
    lens: Description = {"type": "perspective"}
    if opening := camera["lens"]:
        radius = opening.diameter_m / 2
        lens = {
            "type": "thinlens",
            "aperture_radius": radius,
            "focus_distance": opening.focus_m,
        }
    return load_plugin(
        {
            **lens,
            "fov": camera["fov_x_deg"],
            "fov_axis": "x",
            "near_clip": camera["clip"][0],
            "far_clip": camera["clip"][1],
            "to_world": mi.ScalarTransform4f().look_at(eye, target, up),
            "film": {
                "width": width,
                "height": height,
                "crop_offset_y": top,
                "crop_height": bottom - top,
                "rfilter": {"type": "box"},  # the only filter with the same bytes every time
                "component_format": "float32",
                **(_responses() if spectrum else {"type": "hdrfilm", "pixel_format": "rgb"}),
            },
            "sampler": {"type": "multijitter", "sample_count": spp},
            **({"medium": medium} if medium else {}),
        }
    )


def pinhole(camera: Description) -> Description:
    """Describe the same camera with everything sharp: rays go through the centre of its lens."""
    return {**camera, "lens": None}


def _responses() -> Description:
    """A film that holds the integral of radiance over each band; it sorts channels by name."""
    made = variant_bands()
    edges = [(nm - made.width / 2, nm + made.width / 2) for nm in made.wavelengths.tolist()]
    flat = {"type": "regular", "values": "1,1"}
    responses = {
        f"band{number:02d}": {**flat, "wavelength_min": low, "wavelength_max": high}
        for number, (low, high) in enumerate(edges)
    }
    return {"type": "specfilm", **responses}


def _integrators(description: Description) -> dict[str, Any]:
    max_depth = description["integrator"]["max_depth"]
    image = {"type": "path", "max_depth": max_depth, "block_size": BLOCK_SIZE}
    asked = [name for name in GUIDES if name != "position" or description["after"]]
    aovs = {"type": "aov", "block_size": BLOCK_SIZE}
    plans = {
        "image": image,
        "distance": {**aovs, "aovs": "depth:depth"},
        "guides": {**aovs, "aovs": ",".join(f"{name}:{name}" for name in asked)},
        "medium": {**image, "type": "volpath", "max_depth": ORDERS, "rr_depth": ORDERS // 4},
    }
    return {name: load_plugin(plan) for name, plan in plans.items()}


def _box(box: Description) -> Any:
    air = {
        "type": "homogeneous",
        "sigma_t": {"type": "rgb", "value": box["beta"].tolist()},
        "albedo": {"type": "rgb", "value": [box["albedo"]] * 3},
        "phase": {"type": "hg", "g": box["asymmetry"]},
    }
    middle, half = (box["top"] + box["bottom"]) / 2, (box["top"] - box["bottom"]) / 2
    side = box["side"] / 2
    place = mi.ScalarTransform4f().translate([0, 0, middle]).scale([side, side, half])
    cube = {"type": "cube", "id": MEDIUM, "to_world": place, "interior": air}
    return load_plugin({**cube, "bsdf": {"type": "null"}})
