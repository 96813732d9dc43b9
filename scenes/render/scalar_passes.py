"""A frame in a scalar or spectral variant: passes of whole films, with exact haze.

The renderer hands back means over a pixel, and the mean of L·T(d) is not the mean of L times T of
the mean d. With T̄ the pixel's mean transmittance and A the airlight, it is

    mean(L·T + A·(1 − T)) = T̄·mean(L) + mean(A·(1 − T)) + mean((T − T̄)·L).

mean(L) comes from a picture of stratified samples. T̄ and the light of the air come from a film with
a square of pixels for each pixel, one sample in each. The last term, 0 wherever a pixel is all at
one distance, comes from a smaller square in which radiance and distance are passes with one seed,
and so along the same rays (the renderer seeds each film pixel on its own). All three are
independent: nothing is biased.

Measured against 2048 samples a pixel of the JIT driver, sticks in haze of 800 m, 16 samples each:
mean within 1e-4, relMSE 0.0009 (JIT driver: 0.0003). One sample a pass, without strata: unbiased,
relMSE 0.0032. 4 or 16 samples a pass with the pass's mean distance: biased by −0.3 to −0.6 %.

Normals, albedo and ids cost more than the picture in scalar variants, so they come from a guide
pass of at most 2 × 2 samples.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import mitsuba as mi
import numpy as np

from scenes.frame.frame_input import Quality, SampleWatch, sampler_seed
from scenes.render.build import GUIDES, BuiltScene
from scenes.render.haze import Direction, Haze, NumpyArrays, air_along
from scenes.render.samples import (
    Samples,
    pinhole,
    pixel_directions,
    sample_groups,
    sensor,
    square_sides,
)

_IMAGE, _DISTANCE, _CORRECTION, _GUIDES = range(4)


def render_passes(
    built: BuiltScene, haze: Haze, quality: Quality, frame: int, watch: SampleWatch
) -> Samples:
    """Render band by band of rows, all of each that the window has a row of.

    The sample that Z, N and the ids come from is the last of the guide pass's square: below and
    right of the pixel's centre (anywhere in the pixel, under 4 samples); with a lens, it is one
    more through the lens's centre.
    """
    width, height = built.description["camera"]["size"]
    total = Samples.none_of(built, quality)
    step = max(1, quality.most_samples // (width * quality.spp))
    for pixels, taken in total.runs(height, step * width):
        rows = pixels.start // width, pixels.stop // width
        # Fewer than 4 samples come one by one: of them T̄ would be too rough an estimate.
        for run, spp in enumerate((quality.spp,) if quality.spp >= 4 else (1,) * quality.spp):
            band = _Band(built, haze, rows, spp, (quality.seed, frame, run, rows[0]))
            rgb, replaced = band.colour()
            total.add("rgb", pixels, rgb * (spp / quality.spp))
            total.replaced += replaced
            if run == 0:
                band.add_guides(total, 2 if quality.spp >= 4 else 1, quality.coverage)
            watch(spp * taken)
    return total


@dataclass(frozen=True, eq=False)
class _Band:
    """Rows of pixels, (first, one past the last), few enough to trace ``spp`` samples at once."""

    built: BuiltScene
    haze: Haze
    rows: tuple[int, int]
    spp: int
    seed: tuple[int, int, int, int]

    @property
    def camera(self) -> dict[str, Any]:
        return self.built.description["camera"]

    def colour(self) -> tuple[np.ndarray, int]:
        """Picture in its air, linear Rec.709, (h, w, 3), and number of pixels not finite."""
        image = self._image()
        bad = ~np.isfinite(image)
        replaced = int(np.count_nonzero(bad.any(axis=-1)))
        if self.built.medium:  # the renderer has traced the air along with the rest
            return np.where(bad, 0.0, image), replaced
        # A pixel whose centre is above the horizon by less than half its diagonal has rays that go
        # below it, where the sky that the renderer traces is black: it shows the airlight, too.
        # Rays through a pixel meet in focus: a lens turns them by half its opening over that.
        directions, lens = pixel_directions(self.camera, 1, self.rows), self.camera["lens"]
        tan_x = math.tan(math.radians(self.camera["fov_x_deg"]) / 2)
        half_diagonal = math.sqrt(2) * tan_x / self.camera["size"][0]
        half_diagonal += lens.diameter_m / (2 * lens.focus_m) if lens else 0.0
        horizon_sine = max(self.haze.horizon_sine, half_diagonal)
        below_horizon = directions[..., 2:] < horizon_sine
        transmittance, added = self._mean_haze(below_horizon)
        picture = transmittance * np.where(bad, 0.0, image) + added
        if self.spp > 1:
            picture += self._correction(below_horizon, transmittance)
        return picture @ self.haze.bands.to_rgb, replaced

    def _image(self) -> np.ndarray:
        """Mean radiance without air, of stratified samples, (h, w, bands)."""
        count = len(self.haze.bands.wavelengths)
        total = np.zeros((self.rows[1] - self.rows[0], self.camera["size"][0], count))
        for number, spp in enumerate(sample_groups(self.spp)):
            name = "medium" if self.built.medium else "image"
            total += spp * self._trace(name, 1, spp, _IMAGE, number)
        return total / self.spp

    def _mean_haze(self, below_horizon: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean T of each pixel, and mean light that the air adds, (h, w, bands) each."""
        sums = np.zeros((2, *below_horizon.shape[:2], len(self.haze.bands.wavelengths)))
        for number, side in enumerate(square_sides(self.spp)):
            found = self._ray_haze(_DISTANCE, number, side, below_horizon)
            sums += np.stack([_pixel_sum(each, side) for each in found])
        transmittance, added = sums / self.spp
        return transmittance, added

    def _correction(self, below_horizon: np.ndarray, mean: np.ndarray) -> np.ndarray:
        """Mean of (T − T̄)·L over a quarter of the samples, T̄ being ``mean``, (h, w, bands)."""
        count = max(1, self.spp // 4)
        total = np.zeros_like(mean)
        for number, side in enumerate(square_sides(count)):
            radiance = self._trace("image", side, 1, _CORRECTION, number)
            transmittance, _ = self._ray_haze(_CORRECTION, number, side, below_horizon)
            departure = transmittance - _spread(mean, side)
            total += _pixel_sum(departure * np.nan_to_num(radiance, posinf=0.0, neginf=0.0), side)
        return total / count

    def _ray_haze(
        self, stage: int, number: int, side: int, below_horizon: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """T of the ray of each film pixel and the light that the air adds, (h, w, bands) each."""
        distance = self._trace("distance", side, 1, stage, number)[..., :1].astype(np.float64)
        x, y, z = np.split(pixel_directions(self.camera, side, self.rows).astype(np.float64), 3, -1)
        mask = _spread(below_horizon, side)
        return air_along(self.haze, distance, Direction(x, y, z), mask, NumpyArrays)

    def add_guides(self, total: Samples, side: int, coverage: bool) -> None:
        """Albedo, what one sample of each pixel meets, and with ``coverage`` what each one does."""
        guides = self._trace("guides", side, 1, _GUIDES, 0)
        albedo = _pixel_sum(guides[..., GUIDES["albedo"]], side) / side**2
        width = self.camera["size"][0]
        pixels = slice(self.rows[0] * width, self.rows[1] * width)
        total.add("albedo", pixels, albedo / self.haze.bands.even)
        one = guides[side - 1 :: side, side - 1 :: side]
        if self.camera["lens"]:
            seen = {**self.built.description, "camera": pinhole(self.camera)}
            sharp = replace(self, built=replace(self.built, description=seen))
            one = sharp._trace("guides", 1, 1, _GUIDES, 1)
        total.keep(pixels, one)
        if coverage:
            squares = guides.reshape(len(one), side, width, side, -1).swapaxes(1, 2)
            total.count_objects(self.built, pixels, squares.reshape(-1, side**2, guides.shape[-1]))

    def _trace(self, name: str, side: int, spp: int, stage: int, number: int) -> np.ndarray:
        """One pass over a film of ``side`` pixels a side to each pixel, (rows, columns, channels).

        A single sample is the same one in every stage, and its haze exact without a correction.
        """
        rows = (self.rows[0] * side, self.rows[1] * side)
        spectrum = name == "image" and self.haze.bands.is_spectral
        view = sensor(self.camera, side, rows, spp, self.built.medium, spectrum)
        seed = sampler_seed(*self.seed, 0 if self.spp == 1 else stage, number)
        chosen = self.built.integrators[name]
        image = mi.render(self.built.scene, sensor=view, integrator=chosen, spp=spp, seed=seed)
        found = np.array(image)
        if self.built.medium and name == "guides":
            shape, prim = (found[..., GUIDES[k].start] for k in ("shape_index", "prim_index"))
            # Object 0 is the box around the medium: a ray that meets only that met nothing.
            found[self.built.hit_ids(shape, prim)[..., 0] == 0] = 0.0
        return found


def _pixel_sum(film: np.ndarray, side: int) -> np.ndarray:
    """Sum over each pixel's square, (h·side, w·side, c) → (h, w, c)."""
    rows, columns, channels = film.shape
    return film.reshape(rows // side, side, columns // side, side, channels).sum(axis=(1, 3))


def _spread(values: np.ndarray, side: int) -> np.ndarray:
    """Each pixel's value over its square, (h, w, c) → (h·side, w·side, c)."""
    return np.repeat(np.repeat(values, side, axis=0), side, axis=1)
