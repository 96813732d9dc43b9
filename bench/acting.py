"""Scenes of actors, measured: what it saves that some wait, and how near they come to each other.

A crowd acts twice, everyone updated in every frame and by a threshold, timed frame by frame in
turns (processor time, without pruner and renderer). Errors are of every displayed part, against
the same scene on a copy of its state (a forked process) in which all are brought up to date: at
that frame alone, and in all of the ``COPIED`` frames up to it, which is longer than anybody waits.
"""

import math
import multiprocessing
import time
from dataclasses import replace
from multiprocessing.connection import Connection
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from bench.records.records import Column, Key, Point, columns
from lod.arrays import Reals
from lod.crossfade import blend_weights
from lod.pruner import prune
from lod.shapes import Sticks
from lod.update_schedule import TruePose, displacement_px, initial_state
from lod.view import View
from scenes.actors.acting import LONGEST_COAST_S, Acting, Rules
from scenes.actors.performance import (
    ActedFrame,
    Cast,
    Performance,
    X,
    Y,
)
from scenes.presets.load import load_preset, preset_from
from scenes.presets.schema import Preset
from scenes.scene import Scene
from scenes.world.cast import make_acting, make_cast, preset_roles, role_prototypes
from scenes.world.world import make_terrain

FPS = 24
COPIED = round(FPS * LONGEST_COAST_S)
"""Frames for which the copy is kept up to date."""

LOOKS = 4
"""Frames in which errors are looked at."""


class Troupe(NamedTuple):
    """Actors of a scene while they act, and as the pruner sees them."""

    acting: Acting
    cast: Cast


def troupe_of(preset: Preset) -> Troupe:
    """Make the actors of a preset."""
    terrain, roles = make_terrain(preset), tuple(preset_roles(preset))
    acting = make_acting(preset, terrain, roles, role_prototypes(preset, roles))
    names = [each.name for each in roles]
    done = Performance(names, (), acting.act, preset.acting.frames)
    return Troupe(acting, make_cast(preset, terrain, done))


def walkers(
    count: int, side: float, frames: int, threshold: float, seed: int, waving: bool = False
) -> Preset:
    """Make a preset of walkers in a square, seen from 10 m south of it.

    waving  whether they wave as often as is shipped, or never
    """
    options = {"side": min(side, 40.0)} | ({} if waving else {"waves": 0.0})
    if side <= 40.0:
        options |= {"centre_x": 0.0, "centre_y": 0.0}
    troupe = {"model": "figure", "count": count, "side": side, "prototypes": 2}
    who = {"troupes": {"walker": troupe | {"behaviour": "walk", "options": options}}}
    scene = {
        "seed": seed,
        "camera": {"position": (0.0, -side / 2 - 10.0), "height": 2.0},
        "terrain": {"amplitude": 0.0, "reach": 100.0},
        "acting": {"frames": frames, "threshold": threshold},
    }
    return preset_from(scene | who)


def measure_waiting(
    frames: int,
    actors: int,
    seed: int,
    density: float = 0.005,
    threshold: float = 0.5,
    waving: bool = False,
) -> Point:
    """Let a crowd of walkers act, and those wait who are off by less than a threshold [px].

    density  of walkers [1/m²]
    waving   whether they wave as often as is shipped, or never

    Gives columns, of which

    cpu_us   is of each frame but the first, which compiles, by way
    updated  is the number of updates, of ``acted`` in all
    off_mpx  is how far a displayed part is off, against one updated at that frame or in time: the
             99.9th percentile and the largest [px/1000]
    """
    side = math.sqrt(actors / density)
    presets = [walkers(actors, side, frames, each, seed, waving) for each in (0.0, threshold)]
    every, some = (troupe_of(each) for each in presets)
    scene, updates = Scene(presets[1]), 0
    ways = {"all": every, "scheduled": some}
    spent = {way: list[int]() for way in ways}
    copies = dict[int, list[ActedFrame]]()
    off: dict[str, list[Reals]] = {"at once": [], "in time": []}
    looks = np.linspace(min(COPIED, frames), frames, LOOKS).astype(int).tolist()
    for frame in range(1, frames + 1):
        for last in looks:
            if frame == max(1, last - COPIED + 1):
                copies[last] = acted_on_a_copy(some.acting, last - frame + 1)
        at_once = acted_on_a_copy(some.acting, 1) if frame in looks else []
        for way, troupe in ways.items():
            start = time.process_time()
            troupe.cast.performance.frame(frame)
            spent[way].append(round(1e6 * (time.process_time() - start)))
        updates += int(some.cast.performance.frame(frame).updated.sum())
        if frame in looks:
            view = scene.view(frame)
            for error, acted in (("at once", at_once), ("in time", copies.pop(frame))):
                off[error].append(off_px(some.cast, acted[-1], view, frame))
    samples = list(columns({"updated": [updates], "acted": [actors * frames]}))
    samples += (Column("cpu_us", row[1:], {"way": way}) for way, row in spent.items())
    for error, found in off.items():
        pooled = np.concatenate(found)
        for name, px in (("p99.9", np.quantile(pooled, 0.999)), ("most", pooled.max())):
            keys: dict[str, Key] = {"error": error, "statistic": name}
            samples.append(Column("off_mpx", [math.ceil(1000 * float(px))], keys))
    case = {"topic": "acting", "what": "waiting", "actors": actors, "density": density}
    case |= {"threshold": threshold, "waving": waving}
    return Point(case, samples=tuple(samples))


def acted_on_a_copy(acting: Acting, frames: int) -> list[ActedFrame]:
    """Act the next frames on a copy of a scene as it is now, everyone updated in each of them.

    Generators cannot be copied; a process that forks has them all.
    """
    forking = multiprocessing.get_context("fork")
    mine, theirs = forking.Pipe(duplex=False)
    child = forking.Process(target=_act_all, args=(acting, frames, theirs))
    child.start()
    theirs.close()
    acted: list[ActedFrame] = mine.recv()
    child.join()
    return acted


def _act_all(acting: Acting, frames: int, answers: Connection) -> None:
    acting.rules = Rules()
    answers.send([acting.act() for _ in range(frames)])


def off_px(shown: Cast, acted: ActedFrame, view: View, frame: int) -> Reals:
    """Compute how far each displayed part of a cast is from where it has acted to, (p,) [px]."""
    names = shown.performance.names
    there = replace(shown, performance=Performance(names, [acted] * (frame + 1), None, frame))
    return sticks_off_px(shown, there, view)


def sticks_off_px(shown: Cast, true: Cast, view: View) -> Reals:
    """Compute how far each displayed part of one cast is from where another has it, (p,) [px]."""
    cut = prune(shown, view)
    weights = blend_weights(cut, view)
    there = true.later(cut.parts, view, view.time_s)

    def pose(sticks: Sticks) -> TruePose:
        due = np.zeros(len(cut), bool)
        return TruePose(sticks.start, sticks.end, sticks.owner, due, view.camera.eye, view.theta)

    before = initial_state(pose(shown.appearance(cut.parts, weights)))
    return displacement_px(before, pose(true.appearance(there, weights)))


def measure_clearance(
    preset: str | None, people: int, side_m: float, seconds: float, seed: int
) -> Point:
    """Return the least distance of two actors in every frame of some seconds [mm].

    They are those of a preset, who act at its own threshold, or so many people in a square.
    """
    frames, nearest = round(FPS * seconds), []
    if preset is None:
        shown = walkers(people, side_m, frames, 0.0, seed)
    else:
        shown = load_preset(preset, (f"acting.frames={frames}",))
    acting = troupe_of(shown).acting
    for _ in range(frames):
        places = acting.act().places[:, (X, Y)]
        apart = cKDTree(places).query(places, 2)[0][:, 1].min()
        nearest.append(math.floor(1000 * float(apart)))
    case = {"topic": "acting", "what": "clearance", "scene": preset or "people in a square"}
    return Point(case | {"seconds": seconds}, samples=(Column("nearest_mm", nearest),))
