"""A described frame as flat arrays that another renderer's program can read."""

from typing import Any

import numpy as np

from scenes.render.description.scene_description import Description
from scenes.render.mitsuba import variants

SKY_ROWS = 256
"""Rows of the picture of the sky: it has no sun, and changes slowly."""

_MESH = "vertices", "faces", "normals", "colours"


def scene_arrays(description: Description, variant: str) -> dict[str, Any]:
    """Return the frame's arrays: camera, sun and sky, chains of sticks, and meshes.

    points     (p, 4) ends of sticks and their radii, chain by chain [m]
    counts     (c,) how many points each chain has
    tints      (c, 3) albedo of each chain
    sun        (3,) irradiance of what faces the sun; ``sky`` (rows, 2·rows, 3) radiance from all
               directions, rows from the zenith down, of azimuths that fall from +π to −π, east is
               0. Below the horizon it is the airlight, which the eye sees and nothing is lit by
    meshes     how many there are; ``meshN.vertices`` and so on of each
    """
    camera, shapes = description["camera"], description["shapes"].values()
    chained = [chains(each) for each in shapes if each["type"] == "linearcurve"]
    meshes = [each for each in shapes if each["type"] == "mesh"]
    empty = np.zeros((0, 4), np.float32), np.zeros(0, np.int64), np.zeros((0, 3))
    columns = zip(*chained, strict=True) if chained else ([each] for each in empty)
    points, counts, tints = (np.concatenate(list(column)) for column in columns)
    return {
        **{name: camera[name] for name in ("eye", "forward", "up")},
        "lens": np.array([*camera["size"], np.radians(camera["fov_x_deg"])]),
        **dict(zip(("points", "counts", "tints"), (points, counts, tints), strict=True)),
        **light_arrays(description["light"], variant),
        "meshes": len(meshes),
        **{f"mesh{k}.{name}": m[name] for k, m in enumerate(meshes) for name in _MESH},
    }


def chains(curve: Description) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the points, their numbers and the albedos of a curve's chains of joined sticks."""
    first = curve["segment_indices"].astype(np.int64).ravel()
    tint = curve.get("tint", np.zeros(len(first), np.uint32))
    tints = curve.get("tints", np.atleast_2d(curve.get("albedo", np.zeros(3))))
    if not len(first):
        return np.zeros((0, 4), np.float32), np.zeros(0, np.int64), np.zeros((0, 3))
    joined = (np.diff(first) == 1) & (np.diff(tint.astype(np.int64)) == 0)
    begins = np.concatenate(([0], np.flatnonzero(~joined) + 1))
    sticks = np.diff(np.concatenate((begins, [len(first)])))
    counts = sticks + 1
    offset = np.cumsum(counts) - counts
    row = np.repeat(first[begins] - offset, counts) + np.arange(counts.sum())
    points = np.asarray(curve["control_points"]).reshape(-1, 4)[row]
    return points, counts, np.asarray(tints)[tint[begins]]


def light_arrays(light: Description, variant: str) -> dict[str, np.ndarray]:
    """Return the sun's irradiance and direction, and the sky's radiance from all directions."""
    variants.use(variant)
    from scenes.render.haze.horizon_airlight import HORIZON_DEG, sky_radiance
    from scenes.render.mitsuba.emitters import sun_irradiance

    elevation = np.pi * (0.5 - (np.arange(SKY_ROWS) + 0.5) / SKY_ROWS)
    turn = 2 * np.pi * (0.5 - (np.arange(2 * SKY_ROWS) + 0.5) / (2 * SKY_ROWS))
    seen_up = np.maximum(elevation, np.radians(HORIZON_DEG))
    e, a = np.meshgrid(seen_up, turn, indexing="ij")
    towards = np.stack([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)], axis=-1)
    seen = sky_radiance(light, towards.reshape(-1, 3)).reshape(towards.shape)
    return {
        "sky": seen.astype(np.float32),
        "to_sun": light["to_sun"],
        "sun": sun_irradiance(light),
    }
