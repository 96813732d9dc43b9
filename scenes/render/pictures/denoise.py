"""A denoised picture beside the raw one: for looking at, never to be measured.

Open Image Denoise by way of ``mitsuba-oidn`` (the extra ``denoise``), guided by albedo and normals.
It wants samples that a pixel shares with no other, as the box filter has them. The only file that
imports it.
"""

from dataclasses import replace
from importlib import import_module

import numpy as np

from lod.errors import InputError
from scenes.frame.layers import Layers


def check_denoiser() -> None:
    """Raise InputError where there is no denoiser, before anything is rendered for it."""
    try:
        import_module("mitsuba_oidn")
    except ImportError:
        rule, cure = "needs mitsuba-oidn", "pip install 'lodbench[denoise]'"
        raise InputError("output.denoise", True, rule, cure) from None


def denoise(layers: Layers) -> Layers:
    """Add a denoised picture, never negative, to the layers of a frame."""
    import mitsuba_oidn

    picture = mitsuba_oidn.denoise(
        np.array(layers.rgb), albedo=np.array(layers.albedo), normal=np.array(layers.N), hdr=True
    )
    return replace(layers, denoised=np.maximum(np.array(picture), 0.0))
