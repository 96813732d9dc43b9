"""A small pack's world as a target, and pictures of it that a program might hand in."""

from dataclasses import replace

import numpy as np

from bench.methods.known_methods import culled_beyond
from bench.packs.content import settings_of
from bench.submissions.mistakes import camera_of, content_of, rendered_mistakes
from bench.submissions.score import Target
from lod.pruner import prune
from scenes.frame.frame_input import display
from scenes.frame.layers import SKY_Z
from scenes.render.render import build_frame, trace

EDGES_M = 0.0, 20.0, 60.0, 200.0
SIZE = 160, 90
NAME, MORE = "crowd-small", ("air.visibility=1km", "species.tree.density=0.002")
RECIPE = dict(zip(("preset", "settings"), settings_of(NAME), strict=True))
RECIPE["settings"] = (*RECIPE["settings"], *MORE)
REFERENCE_SPP, HANDED_SPP, PASSES = 64, 16, 16


def pictures(frame_input, spp, *seeds):
    """Linear radiance of each seed, and the distances of the last."""
    stage = build_frame(frame_input)
    layers = [trace(stage, replace(frame_input.quality, spp=spp, seed=s)) for s in seeds]
    return [each.rgb.astype(np.float64) for each in layers], layers[-1].Z.astype(np.float64)


def target():
    right = content_of(RECIPE, SIZE).made
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
    content = content_of(RECIPE, SIZE)
    right, scene = content.made, content.scene
    light, fov = scene.preset.light, scene.preset.camera.fov
    ground, *_ = right.displayed

    def cut(view):
        shown = [display(f, prune(f, view), view) for f in scene.world.fields]
        return replace(right, displayed=(ground, *shown))

    def without(name):
        return replace(right, displayed=tuple(d for d in right.displayed if d.name != name))

    inputs = {
        "right": right,
        "coarse": cut(replace(content.view, detail=4.0)),
        "no haze": content_of(RECIPE, SIZE, "air.visibility=clear").made,
        "sun": content_of(RECIPE, SIZE, f"light.sun_azimuth={light.sun_azimuth - 2}").made,
        "high sun": content_of(RECIPE, SIZE, f"light.sun_elevation={light.sun_elevation + 2}").made,
        "late": replace(right, camera=camera_of(content, 2)),
        "fov": content_of(RECIPE, SIZE, f"camera.fov={fov * 1.01}").made,
        "no tree": without("tree"),
        "no figure": without("figure"),
        "beyond 50 m": cut(culled_beyond(content.view, 50.0)),
        "nothing": replace(right, displayed=(ground,)),
    }
    found = {
        name: pictures(each, HANDED_SPP, 7 + number)
        for number, (name, each) in enumerate(inputs.items())
    }
    return {name: rows[0] for name, (rows, _) in found.items()}, found["right"][1]
