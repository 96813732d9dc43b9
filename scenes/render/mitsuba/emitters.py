"""Sun and sky of a frame, as Mitsuba's emitters and as numbers, in whatever variant is set."""

from typing import Any

import mitsuba as mi
import numpy as np

from scenes.render.description.direction_table import interpolate, row_upper
from scenes.render.description.scene_description import Description
from scenes.render.mitsuba.bands import Bands, make_bands
from scenes.render.mitsuba.plugin import load_plugin

_ROWS, _COLUMNS = 256, 144
"""Of a picture of all directions."""


def surroundings(light: Description) -> Any:
    """Make the light from all around: the sky, or its light through a layer of air.

    The latter is a picture of what reaches the ground from each direction, where the frame is lit
    through such a layer.
    """
    if "scattering_layer" not in light:
        return sky(light, sun_scale=0.0)
    up = np.sin(np.pi * (0.5 - (np.arange(_ROWS) + 0.5) / _ROWS))
    turn = (np.arange(_COLUMNS) + 0.5) / _COLUMNS
    table = light["scattering_layer"].sky_from_ground
    turns, rows = np.broadcast_arrays(turn, row_upper(len(table), up)[:, None])
    picture = interpolate(table, rows, turns) * (up > 0)[:, None, None]
    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(picture, np.float32)),
        "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], 90),
    }


def sky(light: Description, sun_scale: float = 1.0, sky_scale: float = 1.0) -> Description:
    """Describe Hosek's and Wilkie's sky and sun, z up; without its sun where ``sun_scale`` is 0."""
    return {
        "type": "sunsky",
        "sun_direction": light["to_sun"].tolist(),
        "turbidity": light["turbidity"],
        "sun_scale": sun_scale,
        "sky_scale": sky_scale,
    }


def sun_disc(light: Description) -> tuple[np.ndarray, float]:
    """Radiance of the sun's disc, (bands,), never negative, and cosine of its angular radius."""
    emitter = load_plugin(sky(light, sky_scale=0.0))
    radius = np.radians(_SUN_APERTURE_DEG / 2)
    return np.maximum(radiance(emitter, light["to_sun"][None])[0], 0.0), float(np.cos(radius))


def variant_bands() -> Bands:
    """The bands of the variant that is set."""
    return make_bands(str(mi.variant()).endswith("_spectral"))


def radiance(emitter: Any, directions: np.ndarray) -> np.ndarray:
    """Radiance of an environment from each direction in each band, (n, 3) → (n, bands)."""
    made = variant_bands()
    if not made.is_spectral:
        return _radiance(emitter, directions)
    columns = [_radiance(emitter, directions, float(nm))[:, 0] for nm in made.wavelengths]
    return made.width * np.stack(columns, axis=1)


def _radiance(emitter: Any, directions: np.ndarray, nm: float = 0.0) -> np.ndarray:
    """(n, 3) → (n, 3), or (n, 4) alike, at one wavelength, in a spectral variant."""
    hit = mi.SurfaceInteraction3f()
    if nm:
        hit.wavelengths = type(hit.wavelengths)(nm)
    if not str(mi.variant()).startswith("scalar_"):
        hit.wi = mi.Vector3f(np.float32(-directions.T))
        return np.array(emitter.eval(hit), np.float64).T
    rows = []
    for direction in directions:
        hit.wi = mi.Vector3f([-float(x) for x in direction])
        rows.append(np.array(emitter.eval(hit), np.float64))
    return np.array(rows)


_SUN_APERTURE_DEG = 0.5358
"""The full width of sunsky's sun."""


def sun_irradiance(light: Description) -> np.ndarray:
    """Irradiance of a surface that faces the sun, E = L·2π(1 − cos r), (bands,)."""
    disc, cosine = sun_disc(light)
    return disc * 2 * np.pi * (1 - cosine)


def sun(light: Description) -> Description:
    """Describe the sun as a directional light of the same irradiance, which has no penumbra."""
    made, irradiance = variant_bands(), sun_irradiance(light)
    if layer := light.get("scattering_layer"):
        irradiance = irradiance * layer.sun_to_ground
    colour: Description = {"type": "rgb", "value": irradiance.tolist()}
    if made.is_spectral:
        low, high = made.wavelengths[[0, -1]].tolist()
        values = ",".join(repr(each) for each in (irradiance / made.width).tolist())
        ends = {"wavelength_min": low, "wavelength_max": high}
        colour = {"type": "regular", "values": values, **ends}
    return {
        "type": "directional",
        "direction": (-light["to_sun"]).tolist(),
        "irradiance": colour,
        "sampling_weight": light["weight"],
    }
