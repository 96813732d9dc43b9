"""Which mistake explains best how a picture differs from its reference?

Each candidate is a picture that the mistake would have made of the reference: a flip, another
gamma, a wider field of view, the pack's own picture without haze or with the sun elsewhere. What it
explains is the share of the squared difference that is gone where the candidate takes the
reference's place,

    1 − Σ (S − C)² / Σ (S − R)²,

of displayed pictures smoothed by a Gaussian of ``SMOOTHED_PX``, which leaves mistakes and takes
most noise away. A candidate of the pack is R + α (V − R), where V is its picture and α is fitted
by least squares, so that half the mistake is found as well.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import affine_transform, gaussian_filter, zoom

from scenes.render.pictures import to_srgb
from scenes.sticks.prototype import LUMINANCE

SMOOTHED_PX = 1.0, 4.0
"""Standard deviations of Gaussians by which pictures are smoothed before they are compared."""

NAMED = 0.4  # the least share of the squared difference that a cause must explain to be named

PARSIMONY = 0.03
"""A cause that was tried later must explain this much more than one that was tried before."""

LARGEST_FOV, LARGEST_SHIFT_PX = 0.05, 8.0
"""Beyond these a picture that fits by zooming or moving is no picture of this camera."""

LEAST_AMOUNT = 0.3  # the least part of a pack's mistake that is named

LEAST_EXPOSURE, LEAST_ZOOM, LEAST_SHIFT_PX = 0.01, 0.001, 0.1
"""Smaller mistakes than these are not named."""

_DROP_BEYOND_M = 20.0, 50.0, 100.0, 200.0


@dataclass(frozen=True)
class Cause:
    """A mistake, in words, and the share of the squared difference that it explains."""

    name: str
    explains: float


def best_cause(
    tested: np.ndarray,
    reference: np.ndarray,
    exposure: float,
    variants: Mapping[str, np.ndarray],
    Z: np.ndarray,
) -> Cause | None:
    """Find the mistake that explains a difference best; None where none explains enough.

    tested, reference   linear radiance, (h, w, 3)
    variants            pictures of the pack that were made with one mistake, by its name
    Z                   distance of what the reference shows [m], (h, w)
    """

    found = Cause("", 0.0)
    for sigma in SMOOTHED_PX:
        # What is smoothed more is less noisy, and says more of light than of edges.
        for cause in _tried(tested, reference, exposure, variants, Z, sigma):
            found = cause if cause.explains > found.explains + PARSIMONY else found
    return found if found.explains >= NAMED else None


def _tried(
    tested: np.ndarray,
    reference: np.ndarray,
    exposure: float,
    variants: Mapping[str, np.ndarray],
    Z: np.ndarray,
    sigma: float,
) -> Iterator[Cause]:
    """Yield every mistake with what it explains of pictures smoothed by sigma [px]."""

    def shown(picture: np.ndarray) -> np.ndarray:
        displayed = to_srgb(picture, exposure)
        return np.asarray(gaussian_filter(displayed, (sigma, sigma, 0), mode="nearest"))

    mine, right = shown(tested), shown(reference)
    all_there_is = float(((mine - right) ** 2).sum())
    if all_there_is == 0:
        return

    def cause(name: str, candidate: np.ndarray) -> Cause:
        return Cause(name, 1 - float(((mine - candidate) ** 2).sum()) / all_there_is)

    for name, candidate in _candidates(tested, reference):
        yield cause(name, shown(candidate))
    scale, dx, dy = registration(mine @ LUMINANCE, right @ LUMINANCE)
    if abs(scale - 1) <= LARGEST_FOV and max(abs(dx), abs(dy)) <= LARGEST_SHIFT_PX:
        if abs(scale - 1) > LEAST_ZOOM:
            zoomed = f"field of view off by {100 * (1 / scale - 1):+.2f} %"
            yield cause(zoomed, shown(moved(reference, scale, 0, 0)))
        if max(abs(dx), abs(dy)) > LEAST_SHIFT_PX:
            turned = f"camera turned by {dx:+.2f}, {dy:+.2f} px"
            yield cause(turned, shown(moved(reference, 1, dx, dy)))
    for name, picture in variants.items():
        change = shown(picture) - right
        size = float((change**2).sum())
        amount = float(((mine - right) * change).sum()) / size if size else 0.0
        if abs(amount) >= LEAST_AMOUNT and (amount > 0 or name.startswith("sun")):
            told = "" if abs(amount - 1) < 0.15 else f", {amount:.2f} times"
            yield cause(name + told, right + amount * change)
    if (bare := variants.get("without things")) is not None:
        for beyond in _DROP_BEYOND_M:
            dropped = np.where((beyond < Z)[..., None], bare, reference)
            yield cause(f"nothing beyond {beyond:g} m", shown(dropped))


def _candidates(tested: np.ndarray, reference: np.ndarray) -> Iterator[tuple[str, np.ndarray]]:
    """Yield mistakes that need nothing but the reference, the plainest first."""
    yield "flipped left to right", reference[:, ::-1]
    yield "upside down", reference[::-1]
    yield "turned by 180°", reference[::-1, ::-1]
    yield "red and blue exchanged", reference[..., ::-1]
    yield "gamma of sRGB, not linear light", to_srgb(reference, 1.0, "linear")
    lit = (tested > 1e-6) & (reference > 1e-6)
    x, y = np.log(reference[lit]), np.log(tested[lit])
    if len(x) > 1:
        factor = float(np.exp(np.median(y - x)))
        if abs(factor - 1) > LEAST_EXPOSURE:
            yield f"exposure times {factor:.3g}", reference * factor
        # Both ends of the line are read from medians of bright and dark pixels: noise is no slope.
        bright, dark = x >= np.quantile(x, 0.7), x <= np.quantile(x, 0.3)
        run = float(np.median(x[bright]) - np.median(x[dark]))
        power = float(np.median(y[bright]) - np.median(y[dark])) / run if run > 0.05 else 1.0
        offset = float(np.median(y - power * x))
        light = np.maximum(reference, 0.0)
        if power > 0 and abs(power - 1) > 2 * LEAST_EXPOSURE:
            yield f"gamma {1 / power:.2f}", np.exp(offset) * light**power
    for sigma in (1.0, 2.0, 4.0):
        blurred = gaussian_filter(reference, (sigma, sigma, 0), mode="nearest")
        yield f"blurred by {sigma:g} px", blurred
    for order, how in ((0, "pixel by pixel"), (1, "smoothly")):
        yield f"half size, enlarged {how}", enlarged(halved(reference), reference.shape, order)


def halved(picture: np.ndarray) -> np.ndarray:
    """Return the means of squares of two by two pixels; an odd row or column is left out."""
    h, w = (n // 2 * 2 for n in picture.shape[:2])
    means: np.ndarray = picture[:h, :w].reshape(h // 2, 2, w // 2, 2, -1).mean(axis=(1, 3))
    return means


def enlarged(picture: np.ndarray, shape: tuple[int, ...], order: int) -> np.ndarray:
    """Return a picture at another size, (h, w, 3), by repeated pixels (0) or linearly (1)."""
    factors = (shape[0] / picture.shape[0], shape[1] / picture.shape[1], 1)
    made: np.ndarray = zoom(picture, factors, order=order, mode="nearest", grid_mode=True)
    return made


def moved(picture: np.ndarray, scale: float, dx: float, dy: float) -> np.ndarray:
    """Return a picture whose content is enlarged about its middle, then moved right and down."""
    middle = (np.array(picture.shape[:2]) - 1) / 2
    offset = middle - (middle + np.array([dy, dx])) / scale
    planes = np.atleast_3d(picture)
    made = [
        affine_transform(planes[..., k], [1 / scale] * 2, offset, order=1, mode="nearest")
        for k in range(planes.shape[2])
    ]
    return np.stack(made, axis=2).reshape(picture.shape)


def registration(tested: np.ndarray, reference: np.ndarray) -> tuple[float, float, float]:
    """Return by what the reference is enlarged, and moved right and down [px], to fit best.

    Least squares over x·∂R/∂x + y·∂R/∂y and both derivatives, from coarse to fine (Lucas and
    Kanade, "An Iterative Image Registration Technique", 1981). A box of the picture's rim is left
    out.
    """
    scale, dx, dy = 1.0, 0.0, 0.0
    h, w = reference.shape
    rim = max(2, min(h, w) // 20)
    inside = np.s_[rim : h - rim, rim : w - rim]
    y, x = (each[inside] for each in np.mgrid[:h, :w] - (np.array([h, w])[:, None, None] - 1) / 2)
    for sigma in (4.0, 4.0, 2.0, 2.0, 1.0, 1.0):
        now = gaussian_filter(moved(reference, scale, dx, dy), sigma)
        apart = (gaussian_filter(tested, sigma) - now)[inside].ravel()
        down, right = (each[inside] for each in np.gradient(now))
        columns = np.stack([-(x * right + y * down).ravel(), -right.ravel(), -down.ravel()], axis=1)
        grown, more_x, more_y = np.linalg.lstsq(columns, apart, rcond=None)[0]
        scale, dx, dy = scale * (1 + grown), dx + more_x, dy + more_y
    return float(scale), float(dx), float(dy)
