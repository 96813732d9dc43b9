"""Shapes of a description as the renderer's own, whose code is the same from frame to frame."""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.render.description import ALIGNMENT, Copies, Description, aligned
from scenes.render.light import load_plugin, variant_bands


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
    at_once = {} if variant_bands().is_spectral else {"vertex_color": colours}
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
