"""Haze as a medium that scatters light: the physical reference for the closed forms of haze.

A homogeneous medium fills a finite box with the scene and the eye in it, from ``DEPTH_M`` below
all that is displayed to ``HEIGHT_M`` above it, wide enough that nothing shows beyond (T < 2e-7).
It scatters by Henyey & Greenstein's phase function (Astrophys. J. 93, 1941). Its asymmetry and
albedo are those of clean continental air at 550 nm, all bands alike (OPAC: Hess, Koepke & Schult,
Bull. Amer. Meteor. Soc. 79, 1998, table 4).

Sun and sky light the box from without, and the model of the sky holds a whole atmosphere already.
So the box is a thin layer below it: the higher, the more light it takes from the ground twice. The
sun's disc is not drawn. Slower and noisier than the closed forms: for comparison.
"""

import numpy as np

from lod.air import Air, rgb_extinction
from lod.errors import InputError
from scenes.render.description.scene_description import MEDIUM, Description

ASYMMETRY, ALBEDO = 0.71, 0.97
"""Asymmetry and albedo of single scattering."""

HEIGHT_M, DEPTH_M = 10.0, 1.0
"""How far the box reaches above and below all that is displayed and the eye [m]."""

_FAR = 4.0
"""The box reaches this many visibilities, at least."""


def with_medium(description: Description, air: Air) -> Description:
    """Put a description into a box of air, whose size and contents are its ``medium``."""
    if air.mist is not None:
        raise InputError("--haze", "medium", "even haze, and there is mist", "try analytic")
    if air.visibility_m is None:
        raise InputError("--haze", "medium", "haze to scatter light", "give it a --visibility")
    bottom, top, reach = extent(description)
    far = _FAR * air.visibility_m + float(np.abs(description["camera"]["eye"][:2]).max())
    box = {
        "side": 2 * max(reach + 1, far),
        "bottom": bottom,
        "top": top,
        "beta": rgb_extinction(air),
        "albedo": ALBEDO,
        "asymmetry": ASYMMETRY,
    }
    no_object = {MEDIUM: np.zeros(12, np.uint32)}
    return {**description, MEDIUM: box, "owners": {**description["owners"], **no_object}}


def extent(description: Description) -> tuple[float, float, float]:
    """Bottom and top of the box, and the greatest coordinate of anything in it [m]."""
    points = [description["camera"]["eye"][None], *map(_points, description["shapes"].values())]
    present = [each for each in points if len(each)]
    lowest = min(float(each[:, 2].min()) for each in present)
    highest = max(float(each[:, 2].max()) for each in present)
    reach = max(float(np.abs(each).max()) for each in present)
    return lowest - DEPTH_M, highest + HEIGHT_M, reach


def _points(shape: Description) -> np.ndarray:
    """Where a shape is, (n, 3), radii included."""
    if shape["type"] == "mesh":
        return shape["vertices"]
    centres, radii = shape["control_points"][:, :3], shape["control_points"][:, 3:]
    return np.concatenate((centres - radii, centres + radii))
