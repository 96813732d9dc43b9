"""From a plain description to a Mitsuba scene, in whatever variant is set.

Shapes become the renderer's own, whose code is the same from frame to frame. In a JIT variant
``Surfaces`` says what rays meet. The renderer completes a hit on an instance by calls to every
shape there is from within each instance, which takes N². Here the shape itself completes it, in its
own coordinates, and tables give the model that an instance shares, where it stands and how it is
turned.
"""

import gc
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple
from weakref import WeakSet

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.render.description import ALIGNMENT, MEDIUM, Copies, Description, aligned


def load_plugin(plan: dict[str, Any]) -> Any:
    """Load a Mitsuba plugin, its parts one after the other.

    Loaded in parallel they are numbered by chance, and a JIT variant compiles their numbers.
    """
    return mi.load_dict(plan, parallel=False)


def segment_albedo(tint: np.ndarray, tints: np.ndarray) -> Any:
    """Make a texture that gives each segment the albedo, of (k, 3), that its tint (s,) numbers."""
    texture = load_plugin({"type": _registered(str(mi.variant()))})
    texture.tint = mi.UInt32(tint)
    texture.tints = mi.Float(tints.astype(np.float32).reshape(-1))
    return texture


@lru_cache(maxsize=4)
def _registered(variant: str) -> str:
    """Register the texture with the variant that is set; gives its name."""

    class TintOfSegments(mi.Texture):
        """Albedo by the number of the primitive that was met."""

        tint: Any
        tints: Any

        def eval(self, si: Any, active: Any = True) -> Any:
            row = dr.gather(mi.UInt32, self.tint, si.prim_index, active)
            return dr.gather(mi.Color3f, self.tints, row, active)

        def is_spatially_varying(self) -> bool:
            return True

    mi.register_texture("tint_of_segments", TintOfSegments)
    return "tint_of_segments"


def reach_of(copies: Copies) -> float:
    """Bound every coordinate of the copies of models [m]."""
    shapes = [shape for model in copies.models for shape, _ in model]
    own = [s["vertices"] if s["type"] == "mesh" else s["control_points"] for s in shapes]
    if not len(copies):
        return 0.0
    size = 2 * max(float(np.abs(each).max()) for each in own)
    return float(np.abs(copies.place).max()) + size


def instance_plugins(copies: Copies, models: Sequence[Sequence[Any]]) -> Description:
    """Make the renderer's copies, named by their rows; ``models`` are the shapes of each."""
    groups = [
        load_plugin({"type": "shapegroup", **{f"shape{k}": each for k, each in enumerate(model)}})
        for model in models
    ]
    named = {f"model{k}": each for k, each in enumerate(groups)}  # a scene must have them, too
    places = np.zeros((len(copies), 4, 4))
    (cos, sin), places[:, 2, 2], places[:, 3, 3] = copies.turn.T, 1.0, 1.0
    places[:, 0, 0], places[:, 0, 1], places[:, 1, 0], places[:, 1, 1] = cos, -sin, sin, cos
    places[:, :3, 3] = copies.place
    return named | {
        # One by one: the plans of many at once take as much memory as they themselves.
        str(row): load_plugin(
            {
                "type": "instance",
                "id": str(row),
                "to_world": mi.ScalarTransform4f(place.tolist()),
                "of": groups[of],
            }
        )
        for row, (place, of) in enumerate(zip(places, copies.which.tolist(), strict=True))
    }


def stabilise_kernels(shapes: Description, reach: float = 0.0) -> Description:
    """Add to the shapes what keeps a JIT variant's code the same from frame to frame.

    Compiled into it are the scene's bounds, the number of shapes, and whether a shape has just one
    segment; and each new code costs a second. So two triangles without area, which no ray meets,
    stand at opposite corners of a cube whose side is a power of two; and a tint of which less than
    two sticks are displayed has more, too thin to be met, in a corner.
    """
    arrays = [
        s["vertices"] if s["type"] == "mesh" else s["control_points"] for s in shapes.values()
    ]
    ends = [end for array in arrays if len(array) for end in (array.max(), -array.min())]
    reach = max([reach, *map(float, ends)])
    corner = float(2.0 ** np.ceil(np.log2(max(reach, 1.0)) + 0.5))
    filled = {
        name: shape
        if shape["type"] == "mesh" or len(shape["segment_indices"]) > 1
        else _with_thin(shape, corner)
        for name, shape in shapes.items()
    }
    return {**filled, "outer": _outer(corner)}


def _with_thin(curve: Description, corner: float) -> Description:
    ends = [[corner, corner, share * corner, 1e-6] for share in (1.0, 0.999, 0.998)]
    points, segments = curve["control_points"], curve["segment_indices"]
    more = len(points) + np.arange(2, dtype=np.uint32)
    tint = {"tint": np.append(curve["tint"], [0, 0]).astype(np.uint32)} if "tint" in curve else {}
    return {
        **curve,
        **tint,
        "control_points": np.concatenate((points, np.array(ends, np.float32))),
        "segment_indices": np.concatenate((segments, more)).astype(np.uint32),
    }


def _outer(corner: float) -> Description:
    vertices = np.repeat(np.array([[-corner] * 3, [corner] * 3], np.float32), 3, axis=0)
    up = np.tile(np.array([[0, 0, 1]], np.float32), (6, 1))
    faces = np.arange(6, dtype=np.uint32).reshape(2, 3)
    return {"type": "mesh", "vertices": vertices, "normals": up, "colours": up * 0, "faces": faces}


def file_shape(name: str, shape: Description, folder: Path) -> Description:
    """Describe a mesh or a curve by a file that the renderer loads itself, for scalar variants.

    A shape that Python made has its references counted by Python, whose lock a scalar variant takes
    for every shape at every sample of a guide: with 312 shapes that is over 100 µs a sample.
    """
    path = folder / f"{name}.{'ply' if shape['type'] == 'mesh' else 'txt'}"
    if shape["type"] != "mesh":
        points = shape["control_points"]
        last = np.ones(len(points), bool)
        last[shape["segment_indices"]] = False
        rows = zip(points.tolist(), last.tolist(), strict=True)
        lines = (" ".join(f"{v:.9g}" for v in row) + "\n" * end for row, end in rows)
        path.write_text("\n".join(lines) + "\n")
        reflectance = {"type": "rgb", "value": shape["albedo"].tolist()}
        bsdf = {"type": "diffuse", "reflectance": reflectance}
        return {"type": "linearcurve", "id": name, "filename": str(path), "bsdf": bsdf}
    columns = shape["vertices"], shape["normals"], shape["colours"]
    faces = np.zeros(len(shape["faces"]), np.dtype([("corners", "u1"), ("vertices", "<i4", 3)]))
    faces["corners"], faces["vertices"] = 3, shape["faces"]
    properties = "".join(f"property float {k}\n" for k in ("x", "y", "z", "nx", "ny", "nz", *"rgb"))
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(shape['vertices'])}\n{properties}"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    vertices = np.concatenate(columns, axis=1).astype("<f4")
    path.write_bytes(head.encode() + vertices.tobytes() + faces.tobytes())
    reflectance = {"type": "mesh_attribute", "name": "vertex_color"}
    bsdf = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}
    made = {"type": "ply", "id": name, "filename": str(path), "bsdf": bsdf}
    if "glow" in shape:
        radiance = {"type": "rgb", "value": shape["glow"].tolist()}
        made["emitter"] = {"type": "area", "radiance": radiance}
    return made


def make_shape(name: str, shape: Description, stub: Path) -> Any:
    """Make a mesh or a curve of the renderer; ``stub`` is a file that holds any curve."""
    return _mesh(name, shape) if shape["type"] == "mesh" else _curve(name, shape, stub)


def _curve(name: str, shape: Description, stub: Path) -> Any:
    """The plugin loads only from a file: load a stub of one segment, then replace its arrays."""
    reflectance = (
        segment_albedo(shape["tint"], shape["tints"])
        if "tint" in shape
        else {"type": "rgb", "value": shape["albedo"].tolist()}
    )
    curve = load_plugin(
        {
            "type": "linearcurve",
            "id": name,
            "filename": str(stub),
            "bsdf": {"type": "diffuse", "reflectance": reflectance},
        }
    )
    _replace(
        curve,
        control_points=_where_aligned(shape["control_points"]).reshape(-1),
        segment_indices=shape["segment_indices"],
        control_point_count=len(shape["control_points"]),
    )
    return curve


def _where_aligned(points: np.ndarray) -> np.ndarray:
    """The same where a vector register may load them from: JIT code depends on whether it may."""
    if points.ctypes.data % ALIGNMENT == 0:
        return points
    found = aligned(points.shape)
    found[...] = points
    return found


def _mesh(name: str, shape: Description) -> Any:
    """Triangles with vertex normals, coloured by their vertices, the same from both sides.

    What gives light has one radiance all over, and only outwards.
    """
    reflectance = {"type": "mesh_attribute", "name": "vertex_color"}
    properties = mi.Properties()
    properties["mesh_bsdf"] = load_plugin(
        {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}
    )
    if "glow" in shape:
        radiance = {"type": "rgb", "value": shape["glow"].tolist()}
        properties["mesh_emitter"] = load_plugin({"type": "area", "radiance": radiance})
    # A new attribute is taken number by number: but for spectra, which are fitted to them then, a
    # first vertex has it, and all at once the others.
    colours = shape["colours"].reshape(-1)
    at_once = {} if str(mi.variant()).endswith("_spectral") else {"vertex_color": colours}
    first = colours[:3] if at_once else colours
    mesh = mi.Mesh(name, len(first) // 3, 1, properties, has_vertex_normals=True)
    mesh.add_attribute("vertex_color", 3, first)
    _replace(
        mesh,
        vertex_positions=shape["vertices"].reshape(-1),
        vertex_normals=shape["normals"].reshape(-1),
        faces=shape["faces"].reshape(-1),
        **at_once,
    )
    mesh.set_id(name)
    return mesh


@lru_cache(maxsize=1)
def _finder() -> Any:
    """A class, made once a variant is set: where each of a plugin's own parameters is, by name.

    What mi.traverse gives holds the plugin until Python looks for cycles; till then it costs its
    memory, and a JIT variant compiles code for it.
    """

    class Finder(mi.TraversalCallback):
        def __init__(self) -> None:
            super().__init__()
            self.found: dict[str, tuple[Any, Any]] = {}

        def put(self, name: str, value: Any, flags: int, kind: Any = None) -> None:
            self.found[name] = value, kind

    return Finder


def _replace(plugin: Any, **values: Any) -> None:
    """Set parameters to values of another size, which scalar variants refuse to be assigned."""
    finder = _finder()()
    plugin.traverse(finder)
    for key, value in values.items():
        where, kind = finder.found[key]
        if kind is None:
            mi.set_property(where, value)
        else:
            held: Any = type(mi.get_property(where, kind, plugin))
            mi.set_property(where, kind, value if np.isscalar(value) else held(value))
    plugin.parameters_changed(list(values))
    dr.eval()


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
            albedo = _bounded_albedo(bsdf.eval_diffuse_reflectance(si, active))
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
        albedo = _bounded_albedo(albedo)
        si = dr.zeros(mi.SurfaceInteraction3f, dr.width(valid))
        si.t, si.time = dr.select(valid, hit.t, dr.inf), ray.time
        si.p, si.n = _turned(p, cos, sin) + place, _turned(n, cos, sin)
        si.sh_frame = mi.Frame3f(_turned(shading, cos, sin))
        si.wi, si.prim_index, si.shape = si.to_local(-ray.d), prim, hit.shape
        both = dr.gather(mi.UInt32, self._has_back, target, valid) > 0
        return Met(si, number, albedo, emitted, both | (si.wi.z > 0), mi.Bool(False))


def _bounded_albedo(albedo: Any) -> Any:
    """Clamp an albedo to 0 to 1, and NaN to 0.

    Mitsuba solves for a hit's barycentric coordinates in float32, which fails in triangles some
    10⁴ times as long as wide, such as blades of grass that are just fading in.
    """
    return dr.select(albedo >= 0, dr.minimum(albedo, 1.0), 0.0)


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
        if shape.is_mesh():  # its reflectance asks by a call that every copy in the scene joins
            albedo = mi.Color3f(shape.eval_attribute_3("vertex_color", si, active))
        else:
            albedo = bsdf.eval_diffuse_reflectance(si, active)
        return si.p, si.n, si.sh_frame.n, albedo, emitted

    return complete


GUIDES = {
    "depth": slice(0, 1),
    "sh_normal": slice(1, 4),
    "albedo": slice(4, 7),
    "shape_index": slice(7, 8),
    "prim_index": slice(8, 9),
    "position": slice(9, 12),
}
"""What is known of a hit beside its colour, and in which channels; position for motion only."""

ORDERS = 64  # edges of a path through a medium, bounces and scatterings together

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


def build_scene(description: Description, lights: Description) -> BuiltScene:
    """Build the scene of a description, acceleration structure included, and use it up.

    lights  the sky and the sun, described (``scenes.render.light``)

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
        with _room_for_rays(Path(folder) / "log"):
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


@contextmanager
def _room_for_rays(log: Path) -> Iterator[None]:
    """Raise MemoryError where Embree has none left: the renderer warns, and rays meet nothing."""
    logger: Any = mi.logger()  # type: ignore[operator]
    logger.add_appender(heard := mi.StreamAppender(str(log)))
    try:
        yield
    finally:
        logger.remove_appender(heard)
    if "Embree device error" in heard.read_log():
        raise MemoryError("the renderer has no memory left for what its rays may meet")


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
