"""A pack as text of pbrt-v4 (https://pbrt.org/fileformat-v4): geometry, and a file for each camera.

pbrt has no linear curves and no colours of vertices. A stick is a straight cubic Bézier curve that
is drawn as a cylinder, with a sphere at either end; the ground takes its albedo from a picture in
which each triangle has four texels of its own, between which bilinear filtering is exact.
"""

import gzip
import io
import math
from pathlib import Path

import numpy as np

from bench.packs.content import Content
from lod.camera import Camera
from scenes.render.description import Description, chains

ATLAS = "ground.exr"  # the picture of the ground's albedo


def write_geometry(path: Path, content: Content) -> None:
    """Write the ground, one object of each prototype and an instance of it for each copy."""
    models, which = content.distinct
    with path.open("wb") as raw, gzip.GzipFile("", "wb", 6, raw, mtime=0) as packed:
        out = io.TextIOWrapper(packed, "utf-8")
        out.write("# geometry of a pack of lodbench; metres, z up\n")
        _ground(out, content.ground)
        for row, model in enumerate(models):
            out.write(f'ObjectBegin "m{row:03d}"\n')
            for shape, _ in content.copies.models[model]:
                (_mesh if shape["type"] == "mesh" else _sticks)(out, shape)
            out.write("ObjectEnd\n")
        copies = content.copies
        for row, (x, y, z), (c, s) in zip(
            which.tolist(), copies.place.tolist(), copies.turn.tolist(), strict=True
        ):
            # Column by column.
            numbers = f"{c:.7g} {s:.7g} 0 0 {-s:.7g} {c:.7g} 0 0 0 0 1 0 {x:.7g} {y:.7g} {z:.7g} 1"
            out.write(f'AttributeBegin\nTransform [ {numbers} ]\nObjectInstance "m{row:03d}"\n')
            out.write("AttributeEnd\n")
        out.flush()
        out.detach()


def camera_text(camera: Camera, irradiance: list[float], to_sun: list[float]) -> str:
    """Return the file of one camera, sun and sky included; haze is added to its picture later."""
    eye, ahead, up = (each.tolist() for each in (camera.eye, camera.forward, camera.up))
    target = [a + b for a, b in zip(eye, ahead, strict=True)]
    # The field of view is that of the shorter side; x is mirrored, as pbrt is left-handed.
    shorter = min(1.0, camera.height / camera.width)
    fov = 2 * math.degrees(math.atan(math.tan(camera.fov_x / 2) * shorter))
    numbers = " ".join(f"{each:.9g}" for each in (*eye, *target, *up))
    return f"""Scale -1 1 1
LookAt {numbers}
Camera "perspective" "float fov" [ {fov:.9g} ]
Film "rgb" "integer xresolution" [ {camera.width} ] "integer yresolution" [ {camera.height} ]
  "string filename" [ "out.exr" ]
PixelFilter "box" "float xradius" [ 0.5 ] "float yradius" [ 0.5 ]
Sampler "zsobol" "integer pixelsamples" [ 64 ]
Integrator "volpath" "integer maxdepth" [ 3 ]
WorldBegin
LightSource "infinite" "string filename" [ "sky/equalarea.exr" ]
LightSource "distant" "point3 from" [ {_row(to_sun)} ] "point3 to" [ 0 0 0 ]
  "rgb L" [ {_row(irradiance)} ]
Include "geometry.pbrt.gz"
"""


def atlas_of(colours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lay out corner colours (f, 3, 3) as a picture (2n, 2n, 3); gives texture places (f, 3, 2).

    A triangle has a block of 2 × 2 texels: its corners are the centres of three, and the fourth
    continues the plane through them. v counts upwards from the last row.
    """
    side = max(1, math.ceil(math.sqrt(len(colours))))
    row, column = np.divmod(np.arange(len(colours)), side)
    picture = np.zeros((2 * side, 2 * side, 3), np.float32)
    a, b, c = (colours[:, k] for k in range(3))
    x, y = 2 * column, 2 * row
    for dx, dy, values in ((0, 0, a), (1, 0, b), (0, 1, c), (1, 1, b + c - a)):
        picture[y + dy, x + dx] = values
    at = np.stack([np.stack((x + dx, y + dy), axis=1) for dx, dy in ((0, 0), (1, 0), (0, 1))], 1)
    return picture, (at + 0.5) / (2 * side) * (1, -1) + (0, 1)


def ground_atlas(ground: Description) -> np.ndarray:
    """Return the picture of the ground's albedo."""
    return atlas_of(ground["colours"][ground["faces"]])[0]


def _ground(out: io.TextIOWrapper, ground: Description) -> None:
    out.write(f'Texture "ground" "spectrum" "imagemap" "string filename" [ "{ATLAS}" ]\n')
    out.write('  "string filter" [ "bilinear" ] "string wrap" [ "clamp" ]\n')
    out.write('Material "diffuse" "texture reflectance" [ "ground" ]\n')
    _, places = atlas_of(ground["colours"][ground["faces"]])
    corners = ground["faces"].reshape(-1)
    rows = ground["vertices"][corners], ground["normals"][corners], places.reshape(-1, 2)
    _triangles(out, np.arange(len(corners)), rows)


def _mesh(out: io.TextIOWrapper, shape: Description) -> None:
    colours = shape["colours"][shape["faces"][:, 0]]
    for colour in np.unique(colours, axis=0):
        mine = shape["faces"][(colours == colour).all(axis=1)]
        corners, faces = np.unique(mine, return_inverse=True)
        out.write(f'Material "diffuse" "rgb reflectance" [ {_row(colour)} ]\n')
        rows = shape["vertices"][corners], shape["normals"][corners]
        _triangles(out, faces.reshape(-1), rows)


def _triangles(out: io.TextIOWrapper, corners: np.ndarray, columns: tuple[np.ndarray, ...]) -> None:
    out.write('Shape "trianglemesh" "integer indices" [ ')
    out.write(" ".join(map(str, corners.tolist())))
    for name, values in zip(("point3 P", "normal N", "point2 uv"), columns, strict=False):
        digits = "{:.4g}" if name == "normal N" else "{:.7g}"
        out.write(f' ]\n  "{name}" [ ')
        out.write(" ".join(map(digits.format, values.reshape(-1).tolist())))
    out.write(" ]\n")


def _sticks(out: io.TextIOWrapper, shape: Description) -> None:
    points, counts, tints = chains(shape)
    ends = np.cumsum(counts).tolist()
    rows = points.tolist()
    before = None
    for first, last, tint in zip([0, *ends], ends, tints.tolist(), strict=False):
        if tint != before:
            out.write(f'Material "diffuse" "rgb reflectance" [ {_row(tint)} ]\n')
            before = tint
        for k in range(first, last):
            x, y, z, r = rows[k]
            out.write(f"AttributeBegin\nTranslate {x:.6g} {y:.6g} {z:.6g}\n")
            out.write(f'Shape "sphere" "float radius" [ {r:.5g} ]\nAttributeEnd\n')
        for k in range(first, last - 1):
            a, b = np.array(rows[k]), np.array(rows[k + 1])
            at = " ".join(_row((a + s * (b - a))[:3]) for s in (0, 1 / 3, 2 / 3, 1))
            widths = f'"float width0" [ {2 * a[3]:.5g} ] "float width1" [ {2 * b[3]:.5g} ]'
            out.write(f'Shape "curve" "string type" [ "cylinder" ] "point3 P" [ {at} ]\n')
            out.write(f"  {widths}\n")


def _row(values: object) -> str:
    return " ".join(f"{each:.6g}" for each in np.asarray(values).tolist())
