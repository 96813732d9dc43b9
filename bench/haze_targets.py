"""What visibility do black and grey targets side by side in haze show? (§2.1)

There is a black and a grey target at each of twenty distances up to V, in one row of slots with
gaps between and nothing behind. Through the gaps an endless path is seen, in the same render.
"""

import numpy as np
from jaxtyping import Float64
from scipy.optimize import brentq

from bench.statistics.estimates import Estimate
from lod.air import Air, rgb_extinction
from lod.camera import Camera, Corner, camera_from_heading
from lod.pruner import Cut, Parts, cut_from_parts
from lod.shapes import Triangles
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, Light, Quality
from scenes.render.render import render_frame

DISTANCES = 20
ALBEDOS = (0.0, 0.8)  # the albedos of black and of grey

_SLOT_PX, _EDGE_PX, _ROWS, _FOV_DEG = 6, 1, 4, 6.0
_SLOTS = 2 * len(ALBEDOS) * DISTANCES
LIGHT = Light(sun_azimuth_deg=250.0, sun_elevation_deg=35.0)
HEADING_DEG = 70.0  # the heading of the camera [degrees]; the sun stands behind it

Seen = Float64[np.ndarray, "targets bands"]


def order(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Draw the distance, 1 to DISTANCES, and the albedo of each place, (targets,) each."""
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, 0xA17))))
    place = rng.permutation(len(ALBEDOS) * DISTANCES)
    return place % DISTANCES + 1, place // DISTANCES


def camera() -> Camera:
    """Make a level camera that has all slots in view."""
    size = (_SLOT_PX * _SLOTS, _ROWS)
    return camera_from_heading(Corner(0, 0), np.zeros(3), HEADING_DEG, 0.0, _FOV_DEG, size)


def targets(visibility_m: float, seed: int) -> DisplayedRepresentation:
    """Build the squares across the view, one in every other slot."""
    eye, (step, albedo) = camera(), order(seed)
    count = len(step)
    left = _SLOT_PX * 2 * np.arange(count)
    pixel = 2 * eye.tan_half[0] / eye.width
    across = (np.stack((left, left + _SLOT_PX), axis=1) - eye.width / 2) * pixel
    up = np.array((-1.0, 1.0)) * pixel * _ROWS
    distance = visibility_m * step / DISTANCES
    depth = distance / np.hypot(1.0, across.mean(axis=1))
    x, z = across[:, [0, 1, 1, 0]], np.broadcast_to(up[[0, 0, 1, 1]], (count, 4))
    rays = eye.forward + x[..., None] * eye.right + z[..., None] * eye.up
    first = 4 * np.arange(count)[:, None, None]
    shape = Triangles(
        vertices=(depth[:, None, None] * rays).reshape(-1, 3),
        normals=np.tile(-eye.forward, (4 * count, 1)),
        colours=np.repeat(np.array(ALBEDOS)[albedo], 4)[:, None] * np.ones(3),
        faces=(first + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3),
        owner=np.repeat(np.arange(count), 2),
    )
    return DisplayedRepresentation("targets", _cut(count), shape)


def _cut(count: int) -> Cut:
    zero, rows = np.zeros(count), np.arange(count)
    parts = Parts(
        position=np.zeros((count, 3)),
        centre=np.zeros((count, 3)),
        bound=zero,
        limit=zero,
        limit_offscreen=zero,
        level=np.zeros(count, np.int64),
        object=rows,
        part=rows,
        parent=np.full(count, -1),
        share=np.ones(count),
    )
    return cut_from_parts(parts, count, count)


def look_at(visibility_m: float, quality: Quality) -> tuple[Seen, Seen]:
    """Render the radiance of every target and of the path beside it, in the order of places."""
    visible = targets(visibility_m, quality.seed)
    frame = render_frame(FrameInput(camera(), (visible,), Air(visibility_m), LIGHT, quality))
    slots = frame.rgb.astype(np.float64).reshape(_ROWS, _SLOTS, _SLOT_PX, -1)
    slot = slots[:, :, _EDGE_PX:-_EDGE_PX].mean(axis=(0, 2))
    target, gap = slot[::2], slot[1::2]
    before = np.concatenate((gap[:1], gap[:-1]))
    return target, (gap + before) / 2


def extinction_seen(
    target: Seen, beyond: Seen, distance: np.ndarray, grey: np.ndarray
) -> np.ndarray:
    """Fit β of each band from black and from grey, then their standard errors, (4, bands).

    The model is ln|contrast| = ln C₀ − β·d. It is fitted by least squares with weights exp(−2·β·d),
    since noise is the same at all distances; for black targets C₀ is 1 and is not fitted.
    """
    contrast = np.abs(target / beyond - 1)
    found = [_slope(contrast[~grey], distance[~grey], False)]
    found.append(_slope(contrast[grey], distance[grey], True))
    return np.concatenate([np.array(each) for each in zip(*found, strict=True)])


def _slope(contrast: Seen, d: np.ndarray, level: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return −slope of ln(contrast) for each band, and its standard error."""
    design = np.stack((np.full_like(d, float(level)), -d / d.max()), axis=1)[:, 0 if level else 1 :]
    values, errors = [], []
    for column in contrast.T:
        root = column / column.max()
        fit, *_ = np.linalg.lstsq(design * root[:, None], np.log(column) * root, rcond=None)
        left = (np.log(column) - design @ fit) * root
        scale = left @ left / (len(d) - len(fit))
        cov = scale * np.linalg.inv((design * root[:, None]).T @ (design * root[:, None]))
        values.append(fit[-1] / d.max())
        errors.append(np.sqrt(cov[-1, -1]) / d.max())
    return np.array(values), np.array(errors)


def visibility_seen(beta: np.ndarray, error: np.ndarray) -> Estimate:
    """Estimate the V whose β are nearest to those found, by a weighted mean of logarithms [m].

    Weights are inverse variances; black targets have hardly any variance, so each relative error is
    at least 1e-4. The interval is normal, 95 % and two-sided.
    """
    relative_error = np.maximum(error / beta, 1e-4)
    weight = relative_error**-2 / np.sum(relative_error**-2)

    def miss(log_v: float) -> float:
        return float(weight @ np.log(beta / rgb_extinction(Air(float(np.exp(log_v))))))

    value = float(np.exp(brentq(miss, np.log(100.0), np.log(200e3))))
    relative = float(np.sum(relative_error**-2) ** -0.5)
    half = 1.96 * relative * value
    return Estimate(value, value - half, value + half, relative * value, 1.0, len(beta))
