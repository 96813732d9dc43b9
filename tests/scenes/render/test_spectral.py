"""Light of many wavelengths: the same picture where nothing depends on the wavelength."""

import numpy as np
import pytest

from lod.air import CLEAR, Air, haze_extinction
from lod.errors import InputError
from scenes.frame.frame_input import Quality
from scenes.render import variants
from scenes.render.haze import horizon
from scenes.render.light import make_bands

SPECTRAL = ("scalar_spectral", "llvm_ad_spectral")
AIR = Air(5000.0)


@pytest.fixture(params=SPECTRAL)
def spectral(request):
    if variants.works(request.param) is not True:
        pytest.skip(f"{request.param} does not work here")
    return request.param


def wall(make, variant, distance, albedo, air=AIR, spp=64):
    camera = make.camera(size=(8, 4), fov=1.0, eye=(0, 0, 0))
    return make.rendered(variant, make.wall(distance, albedo), camera=camera, air=air, spp=spp)


def test_even_light_is_the_white_of_even_light():
    """Rec.709 of CIE illuminant E, by colour-science's own XYZ of (1, 1, 1)."""
    from colour import XYZ_to_RGB

    expected = XYZ_to_RGB(np.ones(3), "ITU-R BT.709")
    assert np.allclose(make_bands(True).even, expected, atol=6e-3)


def test_black_shows_the_airlight_of_each_band(make, spectral):
    """Exact: nothing is sampled but where the ray goes."""
    distance = 3000.0
    seen = wall(make, spectral, distance, 0.0).rgb.mean(axis=(0, 1))
    bands = make_bands(True)
    variants.use(spectral)
    light = {"to_sun": make.light.to_sun, "turbidity": make.light.turbidity}
    through = np.exp(-haze_extinction(AIR, bands.wavelengths) * distance)
    expected = (horizon(light)[0] * (1 - through)) @ bands.to_rgb
    assert np.allclose(seen, expected, rtol=2e-3)


def test_colours_and_albedo_survive_upsampling(make, spectral):
    albedo = np.array((0.3, 0.2, 0.1))
    frame = wall(make, spectral, 50.0, albedo, CLEAR, 256)
    grey = wall(make, spectral, 50.0, 0.2, CLEAR, 256)
    ratio = frame.rgb.mean(axis=(0, 1)) / grey.rgb.mean(axis=(0, 1))
    assert np.allclose(ratio, albedo / 0.2, rtol=0.05)
    assert np.allclose(grey.albedo.mean(axis=(0, 1)), 0.2, rtol=0.1)
    assert np.allclose(frame.albedo.mean(axis=(0, 1)), albedo, rtol=0.2)


def test_the_sun_and_sky_are_those_of_the_rgb_variant(make):
    """Within what separates the spectral and the RGB coefficients of the sky's model."""
    frames = []
    for variant in ("scalar_rgb", "scalar_spectral"):
        frames.append(wall(make, variant, 10.0, 0.5, CLEAR, 64).rgb.mean(axis=(0, 1)))
    assert np.allclose(*frames, rtol=0.12)


def test_variants_are_chosen_by_what_light_is_made_of():
    assert variants.choose("auto", spectral=True).endswith("_spectral")
    assert variants.choose("auto").endswith("_rgb")
    with pytest.raises(InputError, match="--spectral"):
        variants.choose("scalar_rgb", spectral=True)
    with pytest.raises(InputError, match="--spectral"):
        variants.choose("scalar_spectral")
    with pytest.raises(InputError, match="--haze"):
        Quality("scalar_spectral", haze="medium")
