"""A frame whose haze is a medium in the scene, in which light scatters, in any variant.

Nothing of scenes/render/haze is applied here: the renderer traces the air along with the rest.
"""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.frame.frame_input import Quality, SampleWatch, sampler_seed
from scenes.render.build import GUIDES, BuiltScene, pinhole, sensor
from scenes.render.camera_rays import pixel_sums, sample_groups, sample_rays
from scenes.render.haze import Haze
from scenes.render.samples import Samples

_IMAGE, _GUIDES = range(2)


def render_medium(
    built: BuiltScene, haze: Haze, quality: Quality, frame: int, watch: SampleWatch
) -> Samples:
    """Render band by band of rows, all of each that the window has a row of.

    ``haze`` is not used, because the air is part of the scene. The sample that Z, N and the ids
    come from is somewhere in the pixel, through the centre of the lens where there is one.
    """
    camera = built.description["camera"]
    width, height = camera["size"]
    total = Samples.none_of(built, quality)
    for number, spp in enumerate(sample_groups(quality.spp)):
        step = max(1, quality.most_samples // (width * spp))
        for pixels, taken in total.runs(height, step * width):
            rows = pixels.start // width, pixels.stop // width
            seed = quality.seed, frame, number, rows[0]
            group = replace(quality, spp=spp, seed=sampler_seed(*seed, _IMAGE))
            image = _image(built, rows, group)
            bad = ~np.isfinite(image)
            total.add("rgb", pixels, np.where(bad, 0.0, image) * (spp / quality.spp))
            total.replaced += int(np.count_nonzero(bad.any(axis=-1)))
            watch(spp * taken)
            if number == 0:
                guides = _guides(built, rows, sampler_seed(*seed, _GUIDES))
                total.add("albedo", pixels, guides[..., GUIDES["albedo"]])
                sharp = guides
                if camera["lens"]:
                    through_centre = built.seen_by(pinhole(camera))
                    sharp = _guides(through_centre, rows, sampler_seed(*seed, _GUIDES))
                total.keep(pixels, sharp)
                if quality.coverage:
                    single = guides.reshape(-1, 1, guides.shape[-1])
                    total.count_objects(built, pixels, single)
    return total


def _guides(built: BuiltScene, rows: tuple[int, int], seed: int) -> np.ndarray:
    """What one ray of each pixel of a band of rows meets, (rows, columns, channels)."""
    guides = _trace(built, "guides", rows, 1, seed)
    shape, prim = (guides[..., GUIDES[k]][..., 0] for k in ("shape_index", "prim_index"))
    # Object 0 is the box around the medium: a ray that meets only that met nothing.
    guides[built.hit_ids(shape, prim)[..., 0] == 0] = 0.0
    return guides


def _image(built: BuiltScene, rows: tuple[int, int], group: Quality) -> np.ndarray:
    """Mean radiance of a band of rows, (rows, columns, 3)."""
    if not group.is_jit:
        return _trace(built, "medium", rows, group.spp, group.seed)
    size = built.description["camera"]["size"]
    view = sensor(built.description["camera"], medium=built.medium)
    pixels = slice(rows[0] * size[0], rows[1] * size[0])
    sampler, ray = sample_rays(view, size, pixels, group)
    colour, _, _ = built.integrators["medium"].sample(built.scene, sampler, ray, built.medium)
    dr.eval(colour)
    return (pixel_sums(colour, group.spp) / group.spp).reshape(-1, size[0], 3)


def _trace(built: BuiltScene, name: str, rows: tuple[int, int], spp: int, seed: int) -> np.ndarray:
    """One pass over a band of rows, (rows, columns, channels)."""
    view = sensor(built.description["camera"], 1, rows, spp, built.medium)
    chosen = built.integrators[name]
    return np.array(mi.render(built.scene, sensor=view, integrator=chosen, spp=spp, seed=seed))
