"""The last door: a plain description becomes a Mitsuba scene, in whatever variant is set."""

import gc
import tempfile
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any
from weakref import WeakSet

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.render.describe import MEDIUM, Description
from scenes.render.emitters import bands, sun, surroundings
from scenes.render.one_shape import tint_of_segments
from scenes.render.plugin import loaded

GUIDES = {
    "depth": slice(0, 1),
    "normal": slice(1, 4),
    "albedo": slice(4, 7),
    "shape_index": slice(7, 8),
    "prim_index": slice(8, 9),
    "position": slice(9, 12),
}
"""What the aov integrator gives beside colour, and in which channels; position for motion only."""

ORDERS = 64
"""Edges of a path through a medium, bounces and scatterings together."""

BLOCK_SIZE = 32
"""Fixed, because Mitsuba derives it from the thread count otherwise, and the noise from it."""


_ALIGNMENT = 64
"""Bytes: a cache line, and the widest vector register."""


@dataclass(frozen=True, eq=False)
class Built:
    """A Mitsuba scene, and what finds its way back from a hit to the parts.

    integrators   "image" alone, "distance" alone, "guides" alone, and "all": image and guides;
        "medium": the image with what its medium does to it
    description  of the frame, without the arrays of what does not move
    names  of the shapes by the renderer's shape number; "" is none, as 0, the sky
    ids    (n, 3) uint32 object, part and level of every primitive; row 0 is the sky
    first  (k,) row of primitive 0 of each shape, by the renderer's shape number
    medium that the eye is in, None in clear air and where haze is worked out after the fact
    """

    scene: Any
    description: Description
    integrators: dict[str, Any]
    names: tuple[str, ...]
    ids: np.ndarray
    first: np.ndarray
    medium: Any = None

    def hit_ids(self, shape: np.ndarray, prim: np.ndarray) -> np.ndarray:
        """Object, part and level of hits given the renderer's shape and primitive numbers."""
        return self.ids[self.first[shape.astype(np.int64)] + prim.astype(np.int64)]


_STILL_THERE: WeakSet[Built] = WeakSet()
"""Scenes that someone holds. Where that is but a cycle, as after the imports of a first frame, it
is broken before the next is built: a JIT variant compiles code for every shape that there is."""


def build(description: Description) -> Built:
    """Build the scene; the acceleration structure is made here.

    Takes ``shapes`` and ``ids`` out of the description, so that nothing is held twice.
    """
    if _STILL_THERE:
        gc.collect()
    shapes, owners = description.pop("shapes"), description.pop("ids")
    moving = {name: shapes[name] for name in description["moves"]}
    medium, contents = None, {}
    with tempfile.TemporaryDirectory() as folder:
        stub = Path(folder) / "stub.txt"
        stub.write_text("0 0 0 1\n0 0 1 1\n")
        steady = _steady(shapes)
        del shapes
        for name in list(steady):
            contents[name] = _shape(name, steady.pop(name), stub)
    if box := description.get(MEDIUM):
        medium = _medium(box)
        contents[MEDIUM] = _box(box, medium)
    lights = {"sky": surroundings(description["light"]), "sun": sun(description["light"])}
    scene = loaded({"type": "scene", **lights, **contents})
    names = _names(scene)
    sky_ids = np.zeros((1, 3), np.uint32)
    tables = [owners[name] if len(owners.get(name, ())) else sky_ids for name in names]
    first = np.cumsum([0] + [len(table) for table in tables])[:-1]
    kept, integrators = {**description, "shapes": moving}, _integrators(description)
    ids = np.concatenate(tables)
    _STILL_THERE.add(built := Built(scene, kept, integrators, names, ids, first, medium))
    return built


def let_go() -> None:
    """Give back the memory that the renderer keeps for its next samples."""
    dr.flush_malloc_cache()


def _names(scene: Any) -> tuple[str, ...]:
    """Names of the shapes by the numbers that hits have of them.

    A JIT variant numbers all shapes that there are, those of other scenes as well.
    """
    names = [shape.id() for shape in scene.shapes()]
    if str(mi.variant()).startswith("scalar_"):
        return ("", *names)
    numbers = np.array(dr.reinterpret_array(mi.UInt32, scene.shapes_dr()))
    found = dict(zip(numbers.tolist(), names, strict=True))
    return tuple(found.get(number, "") for number in range(max(found) + 1))


def sensor(
    camera: Description,
    side: int = 1,
    rows: tuple[int, int] | None = None,
    spp: int = 1,
    medium: Any = None,
    spectrum: bool = False,
) -> Any:
    """The camera, ``side`` film pixels a side to each pixel; only ``rows``, from the top.

    ``medium``: what the eye is in; ``spectrum``: a channel for each band of a spectral variant.
    """
    width, height = (side * pixels for pixels in camera["size"])
    top, bottom = rows or (0, height)
    eye, forward, up = (camera[name].tolist() for name in ("eye", "forward", "up"))
    target = [e + f for e, f in zip(eye, forward, strict=True)]
    return loaded(
        {
            "type": "perspective",
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


def _responses() -> Description:
    """A film that holds the integral of radiance over each band; it sorts channels by name."""
    made = bands()
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
    names = {"depth": "depth", "normal": "sh_normal"}
    asked = [name for name in GUIDES if name != "position" or description["after"]]
    aovs = ",".join(f"{name}:{names.get(name, name)}" for name in asked)
    guides = {"type": "aov", "aovs": aovs, "block_size": BLOCK_SIZE}
    plans = {
        "image": image,
        "distance": {"type": "aov", "aovs": "depth:depth", "block_size": BLOCK_SIZE}
        if bands().is_spectral  # whose film would take a distance for a radiance
        else {"type": "depth", "block_size": BLOCK_SIZE},
        "guides": guides,
        "all": {**guides, "image": image},
        "medium": {**image, "type": "volpath", "max_depth": ORDERS, "rr_depth": ORDERS // 4},
    }
    return {name: loaded(plan) for name, plan in plans.items()}


def _steady(shapes: Description) -> Description:
    """The shapes, with what keeps a JIT variant's code the same from frame to frame.

    Compiled into it are the scene's bounds, the number of shapes, and whether a shape has just one
    segment; and each new code costs a second. So two triangles without area, which no ray meets,
    stand at opposite corners of a cube whose side is a power of two; and a tint of which less than
    two sticks are displayed has more, too thin to be met, in a corner.
    """
    arrays = [
        s["vertices"] if s["type"] == "mesh" else s["control_points"] for s in shapes.values()
    ]
    reach = max((float(np.abs(array).max()) for array in arrays if len(array)), default=1.0)
    corner = float(2.0 ** np.ceil(np.log2(max(reach, 1.0)) + 0.5))
    filled = {
        name: shape
        if shape["type"] == "mesh" or len(shape["segment_indices"]) > 1
        else _with_thin(shape, corner)
        for name, shape in shapes.items()
    }
    return {**filled, "outer": _outer(corner)}


def _with_thin(curve: Description, corner: float) -> Description:
    """A curve of at most one segment with two more that no ray meets, behind its own."""
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


def _shape(name: str, shape: Description, stub: Path) -> Any:
    return _mesh(name, shape) if shape["type"] == "mesh" else _curve(name, shape, stub)


def _curve(name: str, shape: Description, stub: Path) -> Any:
    """The plugin loads only from a file: load a stub of one segment, then replace its arrays."""
    reflectance = (
        tint_of_segments(shape["tint"], shape["tints"])
        if "tint" in shape
        else {"type": "rgb", "value": shape["albedo"].tolist()}
    )
    curve = loaded(
        {
            "type": "linearcurve",
            "id": name,
            "filename": str(stub),
            "bsdf": {"type": "diffuse", "reflectance": reflectance},
        }
    )
    _replace(
        curve,
        control_points=_aligned(shape["control_points"]).reshape(-1),
        segment_indices=shape["segment_indices"],
        control_point_count=len(shape["control_points"]),
    )
    return curve


def _aligned(values: np.ndarray) -> np.ndarray:
    """The same where a vector register may load them from: JIT code depends on whether it may."""
    room = np.empty(values.nbytes + _ALIGNMENT, np.uint8)
    start = -room.ctypes.data % _ALIGNMENT
    found: np.ndarray = room[start : start + values.nbytes].view(values.dtype).reshape(values.shape)
    found[...] = values
    return found


def _mesh(name: str, shape: Description) -> Any:
    """Triangles with vertex normals, coloured by their vertices, the same from both sides.

    What gives light has one radiance all over, and only outwards.
    """
    reflectance = {"type": "mesh_attribute", "name": "vertex_color"}
    properties = mi.Properties()
    properties["mesh_bsdf"] = loaded(
        {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}
    )
    if "glow" in shape:
        radiance = {"type": "rgb", "value": shape["glow"].tolist()}
        properties["mesh_emitter"] = loaded({"type": "area", "radiance": radiance})
    mesh = mi.Mesh(
        name, len(shape["vertices"]), len(shape["faces"]), properties, has_vertex_normals=True
    )
    mesh.add_attribute("vertex_color", 3, shape["colours"].reshape(-1))
    _replace(
        mesh,
        vertex_positions=shape["vertices"].reshape(-1),
        vertex_normals=shape["normals"].reshape(-1),
        faces=shape["faces"].reshape(-1),
    )
    mesh.set_id(name)
    return mesh


def _medium(box: Description) -> Any:
    return loaded(
        {
            "type": "homogeneous",
            "sigma_t": {"type": "rgb", "value": box["beta"].tolist()},
            "albedo": {"type": "rgb", "value": [box["albedo"]] * 3},
            "phase": {"type": "hg", "g": box["asymmetry"]},
        }
    )


def _box(box: Description, medium: Any) -> Any:
    """Twelve triangles about the origin that bend no light."""
    middle, half = (box["top"] + box["bottom"]) / 2, (box["top"] - box["bottom"]) / 2
    side = box["side"] / 2
    place = mi.ScalarTransform4f().translate([0, 0, middle]).scale([side, side, half])
    null = {"type": "null"}
    return loaded(
        {"type": "cube", "id": MEDIUM, "to_world": place, "bsdf": null, "interior": medium}
    )


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
