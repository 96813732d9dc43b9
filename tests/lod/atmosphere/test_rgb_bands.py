"""Closed forms and constants, against the package they were taken from."""

import subprocess
import sys

import numpy as np
import pytest
from colour import MSDS_CMFS, RGB_COLOURSPACES, SDS_ILLUMINANTS, SpectralShape
from colour.contrast import (
    contrast_sensitivity_function_Barten1999,
    pupil_diameter_Barten1999,
    retinal_illuminance_Barten1999,
    sigma_Barten1999,
)
from colour.phenomena import scattering_cross_section
from colour.phenomena.rayleigh import molecular_density

from lod.atmosphere.extinction import rayleigh_extinction
from lod.atmosphere.rgb_bands import rgb_wavelengths
from lod.vision.barten import (
    contrast_sensitivity,
    optics_sigma,
    pupil_diameter,
    retinal_illuminance,
)


def test_the_three_wavelengths_are_the_centroids_of_the_channels():
    shape = SpectralShape(390, 730, 5)
    matching = MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    white = SDS_ILLUMINANTS["D65"].copy().align(shape).values
    to_rgb = RGB_COLOURSPACES["ITU-R BT.709"].matrix_XYZ_to_RGB
    weight = (matching.values @ to_rgb.T) * white[:, None]
    centroid = shape.wavelengths @ weight / weight.sum(axis=0)
    np.testing.assert_allclose(rgb_wavelengths(), centroid, rtol=1e-13)


def test_rayleigh_is_bodhaines():
    nm = np.linspace(300, 1000, 141)
    theirs = scattering_cross_section(nm * 1e-7) * molecular_density() * 100
    np.testing.assert_allclose(rayleigh_extinction(nm), theirs, rtol=1e-14)


@pytest.mark.parametrize("luminance, field", [(100.0, 53.0), (1.0, 10.0), (1e4, 120.0)])
def test_the_eye_is_bartens(luminance, field):
    pupil = pupil_diameter(luminance, field)
    assert pupil == pytest.approx(pupil_diameter_Barten1999(luminance, field), rel=1e-14)
    sigma = optics_sigma(0.5 / 60, 0.08 / 60, pupil)
    assert sigma == pytest.approx(sigma_Barten1999(0.5 / 60, 0.08 / 60, pupil), rel=1e-14)
    light = retinal_illuminance(luminance, pupil)
    assert light == pytest.approx(retinal_illuminance_Barten1999(luminance, pupil), rel=1e-14)
    u = np.geomspace(0.05, 60, 97)
    theirs = contrast_sensitivity_function_Barten1999(
        u, sigma=sigma, k=3.0, T=0.1, X_0=field, n=0.03, E=light
    )
    ours = contrast_sensitivity(u, sigma, 3.0, 0.1, field, 0.03, light)
    np.testing.assert_allclose(ours, theirs, rtol=1e-12)


def test_pruning_in_haze_before_an_eye_does_without_the_package():
    program = (
        "import sys\n"
        "from scenes.preset.load import load_preset\n"
        "from scenes.world.view import view_at\n"
        "from scenes.world.world import build_world\n"
        "preset = load_preset('meadow', ['display.luminance=50', 'species={}'])\n"
        "view_at(build_world(preset), preset, 1)\n"
        "sys.exit('colour' in sys.modules)\n"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0
