"""Closed forms and constants, against the package they were taken from."""

import math
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
from hypothesis import given
from hypothesis import strategies as st

from lod.air import (
    CLEAR,
    Air,
    angstrom_exponent,
    extinction_from_visibility,
    haze_extinction,
    least_extinction,
    rayleigh_extinction,
    rgb_extinction,
    rgb_wavelengths,
)
from lod.errors import InputError
from lod.eye import (
    Display,
    Eye,
    contrast_sensitivity,
    optical_sigma,
    pupil_diameter,
    retinal_illuminance,
)

GREEN = np.array([550.0])
VISIBILITY = st.floats(math.log(50), math.log(3e5)).map(math.exp)


@pytest.mark.parametrize(("V", "beta"), [(1000, 3.912023e-3), (20000, 1.9560115e-4)])
def test_koschmieder_by_hand(V, beta):
    """ln 50 = 3.912023: two percent, not the five of the WMO (2.995732)."""
    assert extinction_from_visibility(V) == pytest.approx(beta, rel=1e-7)


@given(V=VISIBILITY)
def test_two_percent_of_contrast_is_left_at_the_visibility(V):
    assert math.exp(-haze_extinction(Air(V), GREEN)[0] * V) == pytest.approx(0.02)


def test_pure_air_scatters_as_published():
    """Bodhaine et al. (1999), table 3: 4.513e-27 cm² at 0.55 µm; 2.5469e19 molecules/cm³."""
    assert rayleigh_extinction(GREEN)[0] == pytest.approx(4.513e-27 * 2.5469e19 * 100, rel=2e-3)
    blue, red = rayleigh_extinction(np.array([450.0, 650.0]))
    assert blue / red == pytest.approx((650 / 450) ** 4.08, rel=0.01)


@pytest.mark.parametrize(
    ("km", "q"), [(0.2, 0), (0.5, 0), (0.75, 0.25), (1, 0.5), (6, 1.3), (50, 1.3), (90, 1.6)]
)
def test_exponent_of_kim(km, q):
    assert angstrom_exponent(1000.0 * km) == pytest.approx(q)


@given(V=st.floats(2000, 3e5))
def test_blue_is_lost_before_red_in_clean_air(V):
    red, green, blue = rgb_extinction(Air(V))
    assert red < green < blue


@given(V=st.floats(50, 499))
def test_fog_is_grey(V):
    red, _, blue = rgb_extinction(Air(V))
    assert blue / red == pytest.approx(1, abs=6e-3)  # what is left is Rayleigh's


def test_clear_air_takes_nothing():
    assert rgb_extinction(CLEAR).tolist() == [0, 0, 0]
    assert least_extinction(CLEAR) == 0


@pytest.mark.parametrize("V", [0.0, -1.0, 0.5, math.inf, math.nan, 4e5])
def test_bad_visibility_is_refused(V):
    with pytest.raises(InputError, match="visibility"):
        Air(V)


@pytest.mark.parametrize("wavelength", [0.55, 5500.0, math.nan])
def test_wavelengths_are_in_nanometres(wavelength):
    with pytest.raises(InputError, match="wavelength"):
        haze_extinction(Air(1e4), np.array([wavelength]))


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
    sigma = optical_sigma(Display(luminance=luminance, field_deg=field), Eye())
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
        "from scenes.presets.load import load_preset\n"
        "from scenes.scene import Scene\n"
        "preset = load_preset('meadow', ['display.luminance=50', 'species={}'])\n"
        "Scene(preset).view(1)\n"
        "sys.exit('colour' in sys.modules)\n"
    )
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0
