"""A small rendered world as a target, and pictures of it that a program might hand in."""

from dataclasses import replace

import numpy as np

from bench.methods.known_methods import culled_beyond
from bench.submissions.mistakes import rendered_mistakes
from bench.submissions.score import Target
from lod.pruner import prune
from scenes.frame.frame_input import display
from scenes.frame.layers import SKY_Z
from scenes.presets.load import load_preset
from scenes.render.render import build_frame, trace
from scenes.render.variants import choose
from scenes.scene import Scene

EDGES_M = 0.0, 20.0, 60.0, 200.0
SIZE = 160, 90
WORDS = "air.visibility=1km", "render.max_depth=3", "camera.speed=1.4"
RECIPE = {"preset": "crowd", "settings": WORDS}
REFERENCE_SPP, HANDED_SPP, PASSES = 64, 16, 16


def scene_with(*more):
    size = f"render.size={SIZE[0]}x{SIZE[1]}"
    return Scene(load_preset("crowd", (*WORDS, size, *more)))


def pictures(frame_input, spp, *seeds):
    """Linear radiance of each seed, and the distances of the last."""
    stage = build_frame(frame_input)
    layers = [trace(stage, replace(frame_input.quality, spp=spp, seed=s)) for s in seeds]
    return [each.rgb.astype(np.float64) for each in layers], layers[-1].Z.astype(np.float64)


def target():
    right = scene_with().input(1, choose())
    halves, Z = pictures(right, REFERENCE_SPP, 100, 101)
    shares = np.zeros((len(EDGES_M) + 1, *Z.shape))
    stage = build_frame(right)
    for k in range(PASSES):
        met = trace(stage, replace(right.quality, spp=1, seed=200 + k)).Z
        band = np.where(met < SKY_Z, np.digitize(met, EDGES_M[1:]), len(EDGES_M))
        for number, share in enumerate(shares):
            share += (band == number) / PASSES
    wrong = rendered_mistakes(RECIPE, 1, SIZE)
    return Target(tuple(halves), Z, shares, (*EDGES_M, float(SKY_Z)), wrong)


def handed_in():
    """Pictures by seeds of their own, by what was done: rendered right, or with a mistake."""
    right = scene_with()
    light, fov = right.preset.light, right.preset.camera.fov
    kept = [f for f in right.world.fields if f.name != "tree"]
    view = culled_beyond(right.view(1), 50.0)
    near = [display(f, prune(f, view), view) for f in right.world.fields]
    bare = right.with_world(replace(right.world, fields=())).input(1, choose())
    inputs = {
        "right": right.input(1, choose()),
        "coarse": scene_with("view.detail=4").input(1, choose()),
        "no haze": scene_with("air.visibility=clear").input(1, choose()),
        "sun": scene_with(f"light.sun_azimuth={light.sun_azimuth - 2}").input(1, choose()),
        "high sun": scene_with(f"light.sun_elevation={light.sun_elevation + 2}").input(1, choose()),
        "late": right.input(2, choose()),
        "fov": scene_with(f"camera.fov={fov * 1.01}").input(1, choose()),
        "no tree": right.with_world(replace(right.world, fields=tuple(kept))).input(1, choose()),
        "beyond 50 m": replace(bare, displayed=(*bare.displayed, *near)),
        "nothing": bare,
    }
    found = {
        name: pictures(each, HANDED_SPP, 7 + k) for k, (name, each) in enumerate(inputs.items())
    }
    return {name: rows[0] for name, (rows, _) in found.items()}, found["right"][1]
