"""Read a pack for a renderer: geometry from its USD, and camera, light and haze from its numbers.

It needs NumPy, usd-core (``pxr``) and OpenEXR, and nothing of lodbench. Copies are flattened:
every stick and triangle stands in the coordinates of the pack.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass
class Geometry:
    """All that stands in a pack.

    points  (p, 4) ends of sticks and their radii, chain by chain [m]
    counts  (c,) how many points each chain has; ``tints`` (c, 3) its albedo
    meshes  (vertices (v, 3), faces (f, 3), normals (v, 3), albedos (v, 3)) of each
    """

    points: np.ndarray
    counts: np.ndarray
    tints: np.ndarray
    meshes: list


def read_numbers(folder):
    """Return a pack's numbers, and the still's camera."""
    numbers = json.loads((Path(folder) / "pack.json").read_text())
    return numbers, json.loads((Path(folder) / "camera.json").read_text())


def read_geometry(scene):
    """Read ``geometry.usdc`` beside a pack's scene, every copy where it stands."""
    chains, meshes = [(np.zeros((0, 4)), np.zeros(0, np.int64), np.zeros((0, 3)))], []
    for prims, places, turn in placed(scene):
        for prim in prims:
            _add(prim, places, turn, chains, meshes)
    return _geometry(chains, meshes)


def read_models(scene):
    """Yield each model in its own coordinates, with where its copies stand and are turned.

    places (n, 3), turn (n, 2) as cosine and sine about the vertical.
    """
    for prims, places, turn in placed(scene):
        chains, meshes = [(np.zeros((0, 4)), np.zeros(0, np.int64), np.zeros((0, 3)))], []
        for prim in prims:
            _add(prim, np.zeros((1, 3)), np.array([[1.0, 0.0]]), chains, meshes)
        yield _geometry(chains, meshes), places, turn


def _geometry(chains, meshes):
    points, counts, tints = (np.concatenate(each) for each in zip(*chains, strict=True))
    return Geometry(points.astype(np.float32), counts.astype(np.int64), tints, meshes)


def placed(scene):
    """Yield the prims of each model, and where its copies stand; what is no copy stands once."""
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(Path(scene).parent / "geometry.usdc"))
    every = list(stage.Traverse())
    shelves = [UsdGeom.PointInstancer(p) for p in every if p.IsA(UsdGeom.PointInstancer)]
    below = tuple(f"{each.GetPath()}/" for each in shelves)
    alone = [prim for prim in every if not str(prim.GetPath()).startswith(below)]
    yield alone, np.zeros((1, 3)), np.array([[1.0, 0.0]])
    for instancer in shelves:
        which = np.array(instancer.GetProtoIndicesAttr().Get())
        places = np.array(instancer.GetPositionsAttr().Get(), np.float64)
        turns = instancer.GetOrientationsfAttr().Get() or instancer.GetOrientationsAttr().Get()
        # Copies are turned about the vertical: (w, 0, 0, z).
        half = np.array([(float(q.GetReal()), float(q.GetImaginary()[2])) for q in turns])
        turn = np.stack([half[:, 0] ** 2 - half[:, 1] ** 2, 2 * half[:, 0] * half[:, 1]], axis=1)
        for row, path in enumerate(instancer.GetPrototypesRel().GetTargets()):
            mine = which == row
            yield list(Usd.PrimRange(stage.GetPrimAtPath(path))), places[mine], turn[mine]


def _moved(vectors, places, turn):
    """Turn and move vectors, (n, 3), to where every copy is, (copies * n, 3)."""
    cos, sin = turn[:, :1], turn[:, 1:]
    x, y, z = vectors.T.astype(np.float64)
    found = np.stack([cos * x - sin * y, sin * x + cos * y, np.broadcast_to(z, (len(cos), len(z)))])
    return (found.transpose(1, 2, 0) + places[:, None, :]).reshape(-1, 3)


def _add(prim, places, turn, chains, meshes):
    from pxr import UsdGeom

    copies = len(places)
    if not copies:
        return
    if prim.IsA(UsdGeom.BasisCurves):
        curves = UsdGeom.BasisCurves(prim)
        points = np.array(curves.GetPointsAttr().Get())
        widths = np.array(curves.GetWidthsAttr().Get())
        counts = np.array(curves.GetCurveVertexCountsAttr().Get())
        tints = np.array(curves.GetDisplayColorAttr().Get(), np.float64)
        tints = np.broadcast_to(tints, (len(counts), 3))
        ends = _moved(points, places, turn)
        radii = np.tile(widths / 2, copies)[:, None]
        chains.append(
            (np.hstack([ends, radii]), np.tile(counts, copies), np.tile(tints, (copies, 1)))
        )
    elif prim.IsA(UsdGeom.Mesh):
        mesh = UsdGeom.Mesh(prim)
        points = np.array(mesh.GetPointsAttr().Get())
        faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
        normals = np.array(mesh.GetNormalsAttr().Get())
        colours = np.array(mesh.GetDisplayColorAttr().Get())
        shift = len(points) * np.arange(copies)[:, None, None]
        meshes.append(
            (
                _moved(points, places, turn).astype(np.float32),
                (faces + shift).reshape(-1, 3).astype(np.uint32),
                _moved(normals, np.zeros_like(places), turn).astype(np.float32),
                np.tile(np.broadcast_to(colours, (len(points), 3)), (copies, 1)),
            )
        )


def hazed(clear, Z, directions, numbers, folder):
    """Lay the pack's haze over samples: L T + A (1 - T), below the horizon A alone.

    clear (h, w, 3) radiance, Z (h, w) distance [m], directions (h, w, 3) unit vectors of rays.
    """
    airlight = read_exr(Path(folder) / numbers["light"]["sky"]["airlight"])[0]
    columns = len(airlight)
    at = np.arctan2(directions[..., 0], directions[..., 1]) / (2 * np.pi) * columns
    low = np.floor(at).astype(int)
    share = (at - low)[..., None]
    A = airlight[low % columns] * (1 - share) + airlight[(low + 1) % columns] * share
    sky = ~(Z < 1e9)
    low_sky = directions[..., 2] < np.sin(np.radians(numbers["haze"]["horizon_deg"]))
    distance = np.where(sky, np.where(low_sky, np.inf, 0.0), Z)[..., None]
    T = np.exp(-np.array(numbers["haze"]["beta"]) * distance)
    return clear * T + A * (1 - T)


def directions_of(camera, width, height):
    """Return the unit vectors of rays through the middles of pixels, (h, w, 3)."""
    forward, up = (np.array(camera[name], np.float64) for name in ("forward", "up"))
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    above = np.cross(right, forward)
    slope = np.tan(np.radians(camera["fov_deg"]) / 2)
    x = ((np.arange(width) + 0.5) / width * 2 - 1) * slope
    y = (1 - (np.arange(height) + 0.5) / height * 2) * slope * height / width
    found = forward + x[None, :, None] * right + y[:, None, None] * above
    return found / np.linalg.norm(found, axis=2, keepdims=True)


def sky_from_north(folder, numbers):
    """Return the sky, (h, w, 3): rows from the zenith, columns clockwise from north (+y)."""
    return read_exr(Path(folder) / numbers["light"]["sky"]["latlong"])


def averaged(picture, k):
    """Return means of squares of k by k pixels: a box filter of one pixel."""
    h, w = picture.shape[0] // k, picture.shape[1] // k
    return picture.reshape(h, k, w, k, -1).mean(axis=(1, 3))


def one_of_each(plane, k, seed):
    """Return one sample of each pixel's k by k, chosen by chance: no corner is preferred."""
    h, w = plane.shape[0] // k, plane.shape[1] // k
    rows, columns = np.random.default_rng(seed).integers(0, k, (2, h, w))
    return plane[np.arange(h)[:, None] * k + rows, np.arange(w) * k + columns]


def read_exr(path):
    """Return R, G and B of a file, (h, w, 3)."""
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        return np.stack([channels[c].pixels for c in "RGB"], axis=2).astype(np.float64)


def write_exr(path, picture, Z=None):
    """Write an entry: R G B, and Z where it is known, as floats."""
    import OpenEXR

    planes = {c: np.ascontiguousarray(picture[..., k], np.float32) for k, c in enumerate("RGB")}
    if Z is not None:
        planes["Z"] = np.ascontiguousarray(Z, np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, planes).write(str(path))
