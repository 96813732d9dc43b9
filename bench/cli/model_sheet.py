"""A model shown down to each of its levels, in light and in the colours of the levels."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from lod.air import CLEAR
from lod.camera import Camera, Corner, camera_from_heading
from lod.metric import METRICS
from lod.pruner import Parts, cut_from_parts, prune
from lod.view import View
from scenes.field.species_field import Placed
from scenes.frame.displayed import display
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.frame.quality import Quality
from scenes.render.pictures import PictureStyle, preview_pixels, save_sheet
from scenes.render.pipeline.render import render_frame
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.terrain.terrain import Terrain
from scenes.world.light import Light

SIDE = 240
"""Pixels of each picture, to either side."""

_FOV_DEG, _PITCH_DEG, _HEADING_DEG = 30.0, -12.0, 35.0


def model_sheet(prototype: RiggedPrototype, out_png: str | Path, variant: str) -> Path:
    """Write one picture of each level above another, both in light and by level, as a PNG.

    ``variant`` is a Mitsuba variant that works here.
    """
    flat = Terrain(seed=0, amplitude=0.0, wavelength=8.0, hurst=0.9, reach=64.0, finest=1.0)
    model = Placed("model", prototype, 0.0, 0.0, 0.0, flat)
    view = View(_camera(prototype), METRICS["full"])
    whole = prune(model, view).parts
    levels = range(int(whole.level.max()) + 1)
    frames = [_frame(model, whole, level, view, variant) for level in levels]
    exposure = PictureStyle().exposure_of(frames[-1].rgb)
    tiles = [
        Image.fromarray(preview_pixels(layers, PictureStyle(view=kind), exposure))
        for kind in ("colour", "level")
        for layers in frames
    ]
    labels = [f"level {level}" for level in levels] * 2
    return save_sheet(tiles, labels, len(frames), out_png)


def _camera(prototype: RiggedPrototype) -> Camera:
    """A camera before the model that has all of it in the picture."""
    tree = prototype.hierarchy
    away = float(tree.B[0]) / np.sin(np.radians(_FOV_DEG / 2))
    a, b = np.radians(_HEADING_DEG), np.radians(_PITCH_DEG)
    ahead = np.array((np.sin(a) * np.cos(b), np.cos(a) * np.cos(b), np.sin(b)))
    middle = np.array((-tree.position[0, 1], tree.position[0, 0], tree.position[0, 2]))
    eye, size = middle - away * ahead, (SIDE, SIDE)
    return camera_from_heading(Corner(0, 0), eye, _HEADING_DEG, _PITCH_DEG, _FOV_DEG, size)


def _frame(model: Placed, whole: Parts, level: int, view: View, variant: str) -> Layers:
    """The model with what is finer than a level hidden."""
    shown = whole.level <= level
    row = np.cumsum(shown) - 1
    parts = whole.take(shown)
    parts = replace(parts, parent=np.where(parts.parent < 0, -1, row[parts.parent]))
    cut = cut_from_parts(parts, 1, len(parts))
    light, quality = Light(200.0, 40.0), Quality(variant, spp=16)
    it = replace(display(model, cut, view), posing=None)
    return render_frame(FrameInput(view.camera, (it,), CLEAR, light, quality))
