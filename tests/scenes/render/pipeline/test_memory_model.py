"""What a frame needs is foretold from counts alone, and refused with both figures."""

import pytest

from lod.errors import InputError
from scenes.frame.frame_input import FrameInput, Quality
from scenes.presets.load import load_preset
from scenes.render.memory import ExtraBuffers, check_memory, predict_bytes, predicted_bytes
from scenes.scene import Scene

SIZE = 640, 360


def test_more_of_anything_needs_more_until_the_samples_go_in_groups():
    least = predict_bytes(0, 0, (16, 9), Quality("llvm_ad_rgb", 1))
    assert 300e6 < least < 600e6
    assert predict_bytes(10**6, 0, (16, 9), Quality("llvm_ad_rgb", 1)) - least == pytest.approx(
        120e6, rel=0.01
    )
    assert predict_bytes(0, 10**6, (16, 9), Quality("llvm_ad_rgb", 1)) - least == pytest.approx(
        204e6, rel=0.01
    )
    few, many, more = (
        predict_bytes(0, 0, SIZE, Quality("scalar_rgb", spp)) for spp in (1, 16, 4096)
    )
    assert few < many == more


def test_what_is_asked_for_beside_the_picture_needs_more():
    plain = predict_bytes(10**6, 0, SIZE, Quality("llvm_ad_rgb", 1))
    more = {
        name: predict_bytes(10**6, 0, SIZE, Quality("llvm_ad_rgb", 1), ExtraBuffers(**{name: True}))
        - plain
        for name in ("motion", "denoised", "shutter")
    }
    assert more == {
        "motion": 126 * 10**6,
        "denoised": 500 * SIZE[0] * SIZE[1],
        "shutter": (2 * 277 - 120) * 10**6,
    }


def test_wavelengths_need_more():
    for driver in ("scalar", "llvm_ad"):
        rgb, spectral = (
            predict_bytes(0, 0, SIZE, Quality(f"{driver}_{c}", 1)) for c in ("rgb", "spectral")
        )
        assert spectral - rgb > 107e6 + 705 * SIZE[0] * SIZE[1] - 1


def test_over_the_limit_is_refused_with_both_figures(zoo):
    needed = predicted_bytes(zoo)
    check_memory(zoo, 0, "frame 3")
    check_memory(zoo, needed, "frame 3")
    with pytest.raises(InputError, match=r"'100 MB': frame 3, with [1-9][0-9,]* sticks and .* MB;"):
        check_memory(zoo, 10**8, "frame 3")


@pytest.fixture(scope="module")
def zoo() -> FrameInput:
    preset = load_preset("zoo", ['render.size="64x36"'])
    return Scene(preset).input(1, "llvm_ad_rgb")
