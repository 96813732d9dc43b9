"""Scenes of actors, measured: what an update costs, what waiting saves, who meets, how feet stand.

A crowd acts twice, everyone updated in every frame and by a threshold, timed frame by frame in
turns (processor time, without pruner and renderer). Errors are of every displayed part, against
the same scene on a copy of its state (a forked process) in which all are brought up to date: at
that frame alone, and in all of the ``COPIED`` frames up to it, which is longer than anybody waits.

Feet are held against those of a field's walkers, who go in circles
(``scenes.field.species_field``), by the same measure: of the heels and balls of both feet the
lowest stands on the ground, as walkers always have a foot on it. How far does it go over the ground
from one frame to the next, if it is the lowest in both, and how far is any below the ground?
"""

import math
import multiprocessing
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from bench.records.records import Column, Key, Point, columns
from lod.actors.object_with_parts import ask
from lod.arrays import Reals
from lod.pruner import blend_weights, prune
from lod.shapes import Sticks
from lod.update_schedule import TruePose, displacement_px, initial_state
from lod.view import View
from scenes.actors.acting import LONGEST_COAST_S, Acting, Acts, Me, Rules
from scenes.actors.behaviours import BEHAVIOURS, walk
from scenes.actors.performance import (
    EIGHTHS,
    PHASE,
    STRIDE_FACTOR,
    YAW,
    ActedFrame,
    Cast,
    Performance,
    X,
    Y,
    posed_prototype,
)
from scenes.field.prototypes import species_prototypes
from scenes.field.species_field import PatrolOrbit
from scenes.figures.gait import heel_and_ball
from scenes.models.catalogue import model_prototypes
from scenes.presets.load import load_preset, preset_from
from scenes.presets.schema import Preset
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose import pose_points
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.scene import Scene, make_terrain
from scenes.world.cast import make_acting, make_cast, preset_roles, role_prototypes

FPS = 24
COPIED = round(FPS * LONGEST_COAST_S)
"""Frames for which the copy is kept up to date."""

LOOKS = 4
"""Frames in which errors are looked at."""

SOUGHT_M = 3.0
"""Pairs of actors are looked at that come nearer than this."""


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
    return _in_a_square(who, side, frames, threshold, seed)


def by_behaviour(count: int, side: float, frames: int, seed: int) -> dict[str, Preset]:
    """Make presets of actors in a square, who do as is shipped: one of each behaviour of bodies.

    Two kinds of rabbits flee from each other, and of those who follow each follows the one before.
    """

    def troupe(model: str, behaviour: str, share: float = 1.0) -> dict[str, Any]:
        many = round(share * count)
        return {"model": model, "count": many, "side": side, "behaviour": behaviour}

    leader = {"model": "figure", "behaviour": "walk", "options": {"side": side, "waves": 0.0}}
    across = math.ceil(math.sqrt(count))
    queue = {}
    for k in range(count):
        x, y = (side * (each / across - 0.5) for each in divmod(k, across))
        behind = {"behaviour": "follow", "options": {"whom": f"queue_{k - 1}"}} if k else {}
        queue[f"queue_{k}"] = leader | behind | {"position": (x, y)}
    hares = {name: troupe("rabbit", "flee", 0.5) for name in ("hare", "rabbit")}
    scenes: dict[str, Mapping[str, Any]] = {
        "follow": {"actors": queue},
        "flee": {"troupes": hares},
        "herd": {"troupes": {"ostrich": troupe("ostrich", "herd")}},
        "face_wind": {"troupes": {"mill": troupe("windmill", "face_wind")}},
    }
    return {
        "walk without waving": walkers(count, side, frames, 0.0, seed),
        "walk": walkers(count, side, frames, 0.0, seed, waving=True),
        **{name: _in_a_square(who, side, frames, 0.0, seed) for name, who in scenes.items()},
    }


def _in_a_square(
    who: Mapping[str, Any], side: float, frames: int, threshold: float, seed: int
) -> Preset:
    scene = {
        "seed": seed,
        "camera": {"position": (0.0, -side / 2 - 10.0), "height": 2.0},
        "terrain": {"amplitude": 0.0, "reach": 100.0},
        "acting": {"frames": frames, "threshold": threshold},
    }
    return preset_from(scene | dict(who))


def measure_waiting(
    frames: int,
    actors: int,
    seed: int,
    density: float = 0.005,
    questions: int = 0,
    threshold: float = 0.5,
    waving: bool = False,
) -> Point:
    """Let a crowd of walkers act, and those wait who are off by less than a threshold [px].

    density    of walkers [1/m²]
    questions  that each asks itself at an update, on top of its own
    waving     whether they wave as often as is shipped, or never

    Gives columns, of which

    cpu_us     is of each frame but the first, which compiles, by way
    updated    is the number of updates, of ``acted`` in all
    off_mpx    is how far a displayed part is off, against one updated at that frame or in time: the
               99.9th percentile and the largest [px/1000]
    displayed  are the parts in the frames that are looked at, by way
    """
    side = math.sqrt(actors / density)
    presets = [walkers(actors, side, frames, each, seed, waving) for each in (0.0, threshold)]
    with _pondering(questions):
        every, some = (troupe_of(each) for each in presets)
    scene, updates = Scene(presets[1]), 0
    ways = {"all": every, "scheduled": some}
    spent, shown = ({way: list[int]() for way in ways} for _ in range(2))
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
            for way, troupe in ways.items():
                shown[way].append(len(prune(troupe.cast, view)))
    samples = list(columns({"updated": [updates], "acted": [actors * frames]}))
    for way in ways:
        samples += columns({"cpu_us": spent[way][1:], "displayed": shown[way]}, way=way)
    for error, found in off.items():
        pooled = np.concatenate(found)
        for name, px in (("p99.9", np.quantile(pooled, 0.999)), ("most", pooled.max())):
            keys: dict[str, Key] = {"error": error, "statistic": name}
            samples.append(Column("off_mpx", [math.ceil(1000 * float(px))], keys))
    case = {"topic": "acting", "what": "waiting", "actors": actors, "density": density}
    case |= {"questions": questions, "threshold": threshold, "waving": waving}
    return Point(case, samples=tuple(samples))


@contextmanager
def _pondering(messages: int) -> Iterator[None]:
    """Have every walker ask itself so many more questions at each update, within."""

    def ponder(me: Me) -> Acts:
        walking, told = walk(me), None
        while True:
            for _ in range(messages):
                yield ask(me.name, "course")
            sent = walking.send(told)
            while sent is not None:
                sent = walking.send((yield sent))
            told = yield None

    BEHAVIOURS["walk"] = ponder if messages else walk
    try:
        yield
    finally:
        BEHAVIOURS["walk"] = walk


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


def measure_updating(
    frames: int, actors: int, side_m: float, everyone: bool, seed: int
) -> list[Point]:
    """Time actors in a square who are all updated in every frame, the first half of which compiles.

    They walk or, where it is ``everyone``, there is a troupe of each behaviour; troupes take turns.

    update_ns  of an actor, in every frame
    prune_ns   of finding, blending and posing an actor's parts in the last frame
    """
    presets = by_behaviour(actors, side_m, 2 * frames, seed)
    if not everyone:
        presets = dict([next(iter(presets.items()))])
    troupes = {who: troupe_of(preset) for who, preset in presets.items()}
    spent: dict[str, list[int]] = {who: [] for who in troupes}
    for frame in range(1, 2 * frames + 1):
        for who, troupe in troupes.items():
            start = time.process_time()
            troupe.cast.performance.frame(frame)
            each_s = (time.process_time() - start) / len(troupe.cast.prototypes)
            spent[who] += [round(1e9 * each_s)] * (frame > frames)
    points = []
    for who, troupe in troupes.items():
        count = len(troupe.cast.prototypes)
        pruned = round(1e9 * _prune_s(troupe, presets[who]) / count)
        samples = columns({"update_ns": spent[who], "prune_ns": [pruned]})
        case = {"what": "updating", "who": who, "actors": count, "side_m": side_m}
        points.append(Point({"topic": "acting", **case}, samples=samples))
    return points


def _prune_s(troupe: Troupe, preset: Preset) -> float:
    view = Scene(preset).view(preset.acting.frames)
    least = math.inf
    for _ in range(4):  # the first one compiles
        start = time.process_time()
        cut = prune(troupe.cast, view)
        troupe.cast.appearance(cut.parts, blend_weights(cut, view))
        least = min(least, time.process_time() - start)
    return least


def measure_clearance(people: int, side_m: float, seconds: float, seed: int) -> Point:
    """Return the least distance of two people in a square in every frame of some seconds [mm]."""
    frames = round(FPS * seconds)
    acting = troupe_of(walkers(people, side_m, frames, 0.0, seed)).acting
    nearest = []
    for _ in range(frames):
        places = acting.act().places[:, (X, Y)]
        apart = cKDTree(places).query(places, 2)[0][:, 1].min()
        nearest.append(math.floor(1000 * float(apart)))
    case = {"topic": "acting", "what": "clearance", "people": people, "side_m": side_m}
    case |= {"seconds": seconds}
    return Point(case, samples=(Column("nearest_mm", nearest),))


def measure_meetings(preset: str, frames: int, seed: int) -> Point:
    """Return how near actors of a preset come to each other, also by models of the two [mm].

    They act at the preset's own threshold.
    """
    scene = load_preset(preset, (f"acting.frames={frames}",))
    roles = tuple(preset_roles(scene))
    performance = troupe_of(scene).cast.performance
    nearest: dict[str, list[int]] = {"all": []}
    updates = 0
    for frame in range(1, frames + 1):
        acted = performance.frame(frame)
        updates += int(acted.updated.sum())
        places, least = acted.places[:, (X, Y)], {"all": SOUGHT_M}
        for a, b in cKDTree(places).query_pairs(SOUGHT_M):
            apart = float(np.hypot(*(places[a] - places[b])))
            pair = " and ".join(sorted((roles[a].table.model, roles[b].table.model)))
            for who in ("all", pair):
                least[who] = min(apart, least.get(who, apart))
        for who, apart in least.items():
            nearest.setdefault(who, []).append(math.floor(1000 * apart))
    moving = sum(1 for each in roles if each.table.behaviour)
    counts = columns({"updated": [updates], "acted": [moving * frames]})
    every = Column("nearest_mm", nearest.pop("all"))
    pairs = (Column("nearest_mm", mm, {"pair": who}) for who, mm in sorted(nearest.items()))
    case: dict[str, Any] = {"topic": "acting", "what": "meetings", "preset": preset}
    case |= {"actors": len(roles), "seconds": frames / FPS}
    return Point(case, samples=(*counts, every, *pairs))


def measure_feet(people: int, seconds: float, of_field: bool, seed: int) -> Point:
    """Return how far a foot that stands slides in a frame, and how deep any sinks [µm].

    Feet are of people who act, from when they set off, or of a field's walkers.
    """
    contacts = (_of_field if of_field else _of_actors)(people, seconds, seed)
    low = contacts[..., 2].argmin(axis=2)
    moved = np.linalg.norm(np.diff(contacts[..., :2], axis=0), axis=-1)
    moved = np.take_along_axis(moved, low[:-1, :, None], axis=2)[..., 0][low[1:] == low[:-1]]
    found = {"mean": moved.mean(), "p99": np.quantile(moved, 0.99)}
    slides = (
        Column("slide_um", [round(1e6 * float(m))], {"statistic": name})
        for name, m in found.items()
    )
    sink = Column("sink_um", [round(-1e6 * float(contacts[..., 2].min()))])
    whose = "a field's walkers" if of_field else "actors"
    case = {"topic": "acting", "what": "feet", "whose": whose, "people": people}
    case |= {"seconds": seconds}
    return Point(case, samples=(*slides, sink))


def _of_actors(people: int, seconds: float, seed: int) -> np.ndarray:
    frames = round(FPS * seconds)
    cast = troupe_of(walkers(people, 40.0, frames, 0.0, seed)).cast
    contacts = []
    for frame in range(1, frames + 1):
        acted = cast.performance.frame(frame)
        who = [
            posed_prototype(prototype, int(place[EIGHTHS]), acted.held.get(k, ()))
            for k, (prototype, place) in enumerate(zip(cast.prototypes, acted.places, strict=True))
        ]
        contacts.append(_soles(who, acted.places))
    return np.array(contacts)


def _of_field(people: int, seconds: float, seed: int) -> np.ndarray:
    """Let walkers of a field go round in circles of 6 m."""
    rng = np.random.default_rng(seed)
    found = model_prototypes("figure", 2, (1.0,), True)
    who = [each for each in found if isinstance(each, RiggedPrototype)] * (people // 2)
    n = len(who)
    motions = [each.motion for each in who]
    stride, period = (
        np.array([getattr(each, name) for each in motions]) for name in ("stride", "period")
    )
    heading, phase = rng.uniform(0, 2 * np.pi, n), rng.random(n)
    orbit = PatrolOrbit(6.0, heading, rng.random(n) < 0.5, phase, stride, period)
    contacts = []
    for frame in range(round(FPS * seconds)):
        now = orbit.at(frame / FPS)
        yaw = np.arctan2(now.sin, now.cos)
        places = (*now.offset.T, yaw, now.phase, np.ones(n), np.full(n, 8.0))
        contacts.append(_soles(who, np.column_stack(places)))
    return np.array(contacts)


def _soles(who: list[RiggedPrototype], places: np.ndarray) -> np.ndarray:
    """Place heel and ball of both feet on level ground: their lowest points, (n, 4, 3) [m]."""
    kinds = {each: row for row, each in enumerate(dict.fromkeys(who))}
    rows = np.array([kinds[each] for each in who])
    tables = species_prototypes(tuple(kinds)).pose_tables
    yaw = places[:, YAW]
    there = Placements(
        places[:, (X, Y)],
        np.cos(yaw),
        np.sin(yaw),
        rows,
        places[:, PHASE],
        places[:, STRIDE_FACTOR],
    )
    instances = place_on_ground(tables, lambda xy: np.zeros(len(xy)), there)
    found = np.empty((len(who), 4, 3))
    for kind, row in kinds.items():
        joints = [kind.rig.row(f"{side} ankle") for side in ("left", "right")]
        points = [(x, 0.0, z, r) for j in joints for x, z, r in heel_and_ball(kind, j)]
        own = np.flatnonzero(rows == row)
        each, item = np.repeat(own, 4), np.tile(np.arange(4), len(own))
        at, radius = np.array(points)[:, :3], np.array(points)[:, 3]
        posed = pose_points(tables, instances, each, item, at, np.repeat(joints, 2))
        posed[:, 2] -= radius[item]
        found[own] = posed.reshape(-1, 4, 3)
    return found
