"""A small rendered world, with its pictures of one mistake each, and pictures handed in."""

from dataclasses import replace

import numpy as np

from bench.methods.known_methods import culled_beyond
from bench.submissions.score import Target
from lod.pruner import prune
from scenes.frame.frame_input import display
from scenes.frame.layers import SKY_Z
from scenes.presets.load import load_preset
from scenes.render.render import build_frame, trace
from scenes.render.variants import choose
from scenes.scene import Scene

EDGES_M = 0.0, 20.0, 60.0, 200.0
SIZE = "160x90"
WORLDS = {
    "crowd": ("crowd", ("air.visibility=1km",)),
    "forest": ("forest", ("species.sward.density=0",)),
}
SUN_DEG = 2.0


def scene_of(world, *more):
    preset, settings = WORLDS[world]
    words = (*settings, f"render.size={SIZE}", "render.max_depth=3", "camera.speed=1.4", *more)
    return Scene(load_preset(preset, words))


def made(scene, frame=1, change=lambda fields: fields, sees=lambda view: view):
    """The input of a frame whose species are chosen by ``change``, and seen by ``sees``."""
    variant = choose()
    rest = scene.with_world(replace(scene.world, fields=())).input(frame, variant)
    view = sees(scene.view(frame))
    shown = [display(f, prune(f, view), view) for f in change(scene.world.fields)]
    return replace(rest, displayed=(*rest.displayed, *shown))


def pictures(frame_input, spp, *seeds):
    """Linear radiance of each seed, and the layers of the last."""
    stage = build_frame(frame_input)
    layers = [trace(stage, replace(frame_input.quality, spp=spp, seed=s)) for s in seeds]
    return [each.rgb.astype(np.float64) for each in layers], layers[-1]


def sun(scene, turn, lift):
    light = scene.preset.light
    azimuth, elevation = light.sun_azimuth + turn, light.sun_elevation + lift
    return f"light.sun_azimuth={azimuth}", f"light.sun_elevation={elevation}"


def changed(world, cause, scene):
    """The input of a frame with one mistake."""
    match cause:
        case "no haze":
            return made(scene_of(world, "air.visibility=clear"))
        case "sun azimuth +2":
            return made(scene_of(world, *sun(scene, SUN_DEG, 0)))
        case "sun elevation +2":
            return made(scene_of(world, *sun(scene, 0, SUN_DEG)))
        case "one frame late":
            return made(scene, 2)
        case "without things":
            return made(scene, change=lambda fields: ())
    name = cause.removeprefix("without ")
    return made(scene, change=lambda fields: [f for f in fields if f.name != name])


def causes(scene):
    names = [f"without {f.name}" for f in scene.world.fields]
    plain = "no haze", "sun azimuth +2", "sun elevation +2", "one frame late", "without things"
    return (*plain, *names)


def target(world, spp=64):
    """The target of a world at 160x90."""
    scene = scene_of(world)
    halves, layers = pictures(made(scene), spp, 100, 101)
    bare = {c: pictures(changed(world, c, scene), spp, 102)[0][0] for c in causes(scene)}
    shares = np.zeros((len(EDGES_M) + 1, *layers.Z.shape))
    stage = build_frame(made(scene))
    passes = 16
    for seed in range(passes):
        Z = trace(stage, replace(made_quality(scene), spp=1, seed=200 + seed)).Z
        band = np.where(Z < SKY_Z, np.digitize(Z, EDGES_M[1:]), len(EDGES_M))
        for k in range(len(shares)):
            shares[k] += (band == k) / passes

    return Target(
        tuple(halves), layers.Z.astype(float), shares, (*EDGES_M, float(SKY_Z)), bare, flip
    )


def made_quality(scene):
    return scene.input(1, choose()).quality


def handed_in(world, spp=16):
    """Pictures of another program, rendered by itself: the right one, and ones with mistakes."""
    scene = scene_of(world)
    found = {}
    found["right"], layers = pictures(made(scene), spp, 7)
    for cause in causes(scene):
        found[cause] = pictures(changed(world, cause, scene), spp, 8)[0]
    found["sun both"] = pictures(made(scene_of(world, *sun(scene, -SUN_DEG, 0))), spp, 8)[0]
    found["beyond 50 m"] = pictures(
        made(scene, sees=lambda view: culled_beyond(view, 50.0)), spp, 9
    )[0]
    fov = scene.preset.camera.fov
    found["fov"] = pictures(made(scene_of(world, f"camera.fov={fov * 1.01}")), spp, 10)[0]
    found["8 px"] = pictures(made(scene_of(world, "view.detail=8")), spp, 11)[0]
    return {k: v[0] for k, v in found.items()}, layers.Z.astype(float)
