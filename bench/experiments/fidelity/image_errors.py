"""How far is one picture from another? Errors of every pair of seeds, as integers.

Pictures are linear radiance. FLIP and SSIM compare them as displayed: at one exposure for a view,
that of its reference, through the curve of scenes.render.pictures, not rounded to 8 bits.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from bench.records.records import Column, columns
from bench.statistics.excess_flip import mean_flip
from scenes.frame.layers import SKY_Z, Layers
from scenes.render.pictures import auto_exposure, to_srgb

BAND_EDGES_M = (0.0, 20.0, 60.0, 200.0)
"""The distances where bands of mean luminance begin [m]; the last band is the sky."""

EPSILON = 0.01
"""The number added to the squared reference of relMSE, in exposed light."""

_LUMINANCE = np.array((0.2126, 0.7152, 0.0722))

Picture = Float64[np.ndarray, "h w 3"]


@dataclass(frozen=True, eq=False)
class Reference:
    """The unpruned view: two pictures of every pair of seeds, and what is measured of them.

    same, other     pictures with the seed of the tested picture, and with another seed
    floors          FLIP, SSIM and relMSE of every pair, as ``picture_errors`` returns them
    exposure, mean  exposure and mean exposed light of all pictures of ``other``
    Z               (h, w) distance of what each pixel shows [m]
    """

    same: tuple[Picture, ...]
    other: tuple[Picture, ...]
    exposure: float
    mean: Picture
    Z: np.ndarray
    floors: dict[str, list[int]]


def reference_of(same: Sequence[Layers], other: Sequence[Layers]) -> Reference:
    """Make the reference of rendered frames."""
    pictures = [[each.rgb.astype(np.float64) for each in row] for row in (same, other)]
    mean = np.mean(pictures[1], axis=0)
    exposure = auto_exposure(mean)
    one, two = map(tuple, pictures)
    plain = Reference(one, two, exposure, mean * exposure, same[0].Z, {})
    floors = {f"{name}_floor": row for name, row in _errors(one, plain).items()}
    return replace(plain, floors=floors)


def picture_errors(tested: Sequence[Picture], whole: Reference) -> tuple[Column, ...]:
    """Measure every pair: FLIP and SSIM with their floors, relMSE, and relMSE without noise.

    Errors are in millionths, luminance is in 10⁻⁹ of its unit.
    """
    unbiased = {"relmse_bias": [_ppm(each) for each in bias(tested, whole)]}
    errors = columns(_errors(tested, whole) | whole.floors | unbiased)
    return (*errors, *_luminances(tested, whole))


def _errors(tested: Sequence[Picture], whole: Reference) -> dict[str, list[int]]:
    """Return FLIP, SSIM and relMSE of every pair, with noise."""
    pairs = range(len(tested))
    test, other = (
        [to_srgb(p, whole.exposure).astype(np.float32) for p in row]
        for row in (tested, whole.other)
    )
    return {
        "flip": [_ppm(mean_flip(test[k], other[k])) for k in pairs],
        "ssim": [_ppm(ssim(test[k], other[k])) for k in pairs],
        "relmse": [_ppm(rel_mse(tested[k], whole.other[k], whole)) for k in pairs],
    }


def ssim(one: np.ndarray, two: np.ndarray) -> float:
    """Return the structural similarity of two displayed pictures (Wang et al. 2004)."""
    from skimage.metrics import structural_similarity

    found = structural_similarity(
        one, two, channel_axis=2, data_range=1.0, gaussian_weights=True, sigma=1.5
    )
    return float(found)


def rel_mse(one: Picture, two: Picture, whole: Reference) -> float:
    """Return the mean of squared difference ÷ squared reference."""
    return _product(one - two, one - two, whole)


def bias(tested: Sequence[Picture], whole: Reference) -> list[float]:
    """Return relMSE without noise: products of differences whose seeds are independent.

    E[(Tᵢ − Rᵢ)(Tⱼ − Rⱼ)] = (E[T] − E[R])² for i ≠ j; here j is the pair after i, and the first
    after the last.
    """
    apart = [one - two for one, two in zip(tested, whole.same, strict=True)]
    return [_product(apart[k - 1], apart[k], whole) for k in range(len(apart))]


def _product(one: Picture, two: Picture, whole: Reference) -> float:
    return float(np.mean(one * two * whole.exposure**2 / (whole.mean**2 + EPSILON)))


def _luminances(tested: Sequence[Picture], whole: Reference) -> list[Column]:
    """Return the mean luminance of every picture, by the reference's bands of distance."""
    edges = (*BAND_EDGES_M, float(SKY_Z))
    made: list[Column] = []
    for low, high in zip(edges, (*edges[1:], np.inf), strict=True):
        mine = (whole.Z >= low) & (whole.Z < high)
        name = band_name(low)
        made.append(Column("pixels", [int(mine.sum())], {"band": name}))
        for which, row in (("tested", tested), ("reference", whole.same)):
            light = [float((p[mine] @ _LUMINANCE).mean()) if mine.any() else 0.0 for p in row]
            nano = [round(1e9 * each) for each in light]
            made.append(Column("luminance", nano, {"picture": which, "band": name}))
    return made


def band_name(low: float) -> str:
    """Return the name of the band that begins at a distance [m]."""
    return "sky" if low == float(SKY_Z) else f"from {low:g} m"


BANDS = tuple(band_name(low) for low in (*BAND_EDGES_M, float(SKY_Z)))


def _ppm(value: float) -> int:
    return round(1e6 * value)
