"""Crowds of walkers and others for the study, and their scenes ready to act.

How many seconds the temporal metric saves where actors act, and how far off those are who wait.

A crowd acts twice, everyone updated in every frame and by a threshold, timed frame by frame in
turns (processor time, without pruner and renderer). Errors are of every displayed part, against
the same scene on a copy of its state (a forked process) in which all are brought up to date: at
that frame alone, and in all of the ``COPIED`` frames up to it, which is longer than anybody waits.

Do people who walk about keep clear of each other, and do their feet stand still?

Feet are held against those of a field's walkers, who go round in circles
(``scenes.figures.patrol``), by the same measure: of the heels and balls of both feet the lowest
stands on the ground, as walkers always have a foot on it. How far does it go over the ground from
one frame to the next, if it is the lowest in both, and how far is any below the ground?

Where the time of an actor's update goes: quaternions, messages, the behaviour, and the pruner.

The processor's clock interrupts the acting every 0.5 ms (ITIMER_PROF), and the module is noted
whose code runs then; what a library does counts for whoever called it. Shares of the notes times
the time of an update, which is measured without interruptions, are the split.
"""

import math
import multiprocessing
import signal
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from types import FrameType
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from lod.actors.message import ask
from lod.arrays import Reals
from lod.crossfade import blend_weights
from lod.pruner import prune
from lod.shapes import Sticks
from lod.update_schedule import TruePose, displacement_px, initial_state
from lod.view import View
from scenes.actors.acting import LONGEST_COAST_S, Acting, Rules
from scenes.actors.behaviour import Acts, Me
from scenes.actors.behaviours import BEHAVIOURS, BODY_M, walk
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
from scenes.figures.gait import heel_and_ball
from scenes.figures.patrol import PatrolOrbit
from scenes.models.catalogue import model_prototypes
from scenes.presets.load import load_preset, preset_from
from scenes.presets.schema import Preset
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose import pose_points
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.scene import Scene
from scenes.world.cast import make_acting, make_cast, preset_roles, role_prototypes
from scenes.world.world import make_terrain


class Troupe(NamedTuple):
    """Actors of a scene while they act, and as the pruner sees them."""

    acting: Acting
    cast: Cast


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
        return {
            "model": model,
            "count": round(share * count),
            "side": side,
            "behaviour": behaviour,
        }

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
    made = {name: _in_a_square(who, side, frames, 0.0, seed) for name, who in scenes.items()}
    walking = {
        "walk without waving": walkers(count, side, frames, 0.0, seed),
        "walk": walkers(count, side, frames, 0.0, seed, waving=True),
    }
    return walking | made


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


def troupe_of(preset: Preset) -> Troupe:
    """Make the actors of a preset."""
    terrain, roles = make_terrain(preset), tuple(preset_roles(preset))
    acting = make_acting(preset, terrain, roles, role_prototypes(preset, roles))
    names = [each.name for each in roles]
    done = Performance(names, (), acting.act, preset.acting.frames)
    return Troupe(acting, make_cast(preset, terrain, done))


@contextmanager
def dearer(messages: int) -> Iterator[None]:
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


COPIED = round(24 * LONGEST_COAST_S)
"""Frames for which the copy is kept up to date."""

AIM_TIMES, AIM_PX = 3.0, 0.5
"""How many times fewer seconds are aimed at, and at which error, its 99.9th percentile."""


@dataclass(frozen=True)
class Crowd:
    """Who acts: walkers, how many of them on a square metre, and questions on top of theirs.

    threshold  of the bound beyond which an actor is updated [px]
    waving     whether they wave as often as is shipped, or never
    """

    actors: int
    density: float = 0.005
    questions: int = 0
    threshold: float = 0.5
    waving: bool = False


@dataclass(frozen=True)
class Saving:
    """What a threshold saves.

    seconds_all, seconds_some  processor time of updating all, and those that are due
    updated      share of all possible updates
    at_once_px   how far a displayed part is off, against one updated at that frame: the 99.9th
                 percentile and the largest [px]
    in_time_px   the same against one updated in every frame for as long as anybody waits
    parts_ratio  parts displayed, some ÷ all
    """

    crowd: Crowd
    seconds_all: float
    seconds_some: float
    updated: float
    at_once_px: tuple[float, float]
    in_time_px: tuple[float, float]
    parts_ratio: float

    @property
    def saved(self) -> float:
        """Return how many times fewer seconds it takes."""
        return self.seconds_all / self.seconds_some


def saving(crowd: Crowd, frames: int, seed: int, looks: int = 4) -> Saving:
    """Let a crowd act in both ways, and compare; errors are looked at in so many frames."""
    side = float(np.sqrt(crowd.actors / crowd.density))
    presets = [
        walkers(crowd.actors, side, frames, each, seed, crowd.waving)
        for each in (0.0, crowd.threshold)
    ]
    with dearer(crowd.questions):
        every, some = (troupe_of(each) for each in presets)
    scene, spent, updates = Scene(presets[1]), np.zeros((2, frames)), 0
    copies: dict[int, list[ActedFrame]] = {}
    off: tuple[list[Reals], list[Reals]] = ([], [])
    parts, times = np.zeros(2), np.linspace(min(COPIED, frames), frames, looks).astype(int).tolist()
    for frame in range(1, frames + 1):
        for last in times:
            if frame == max(1, last - COPIED + 1):
                copies[last] = acted_on_a_copy(some.acting, last - frame + 1)
        at_once = acted_on_a_copy(some.acting, 1) if frame in times else []
        for way, troupe in enumerate((every, some)):
            start = time.process_time()
            troupe.cast.performance.frame(frame)
            spent[way, frame - 1] = time.process_time() - start
        updates += int(some.cast.performance.frame(frame).updated.sum())
        if frame in times:
            view = scene.view(frame)
            for found, acted in zip(off, (at_once, copies.pop(frame)), strict=True):
                found.append(off_px(some.cast, acted[-1], view, frame))
            parts += [len(prune(each.cast, view)) for each in (every, some)]
    all_s, some_s = spent[:, 1:].sum(axis=1).tolist()  # compiling falls into the first
    at_once_px, in_time_px = (_worst(np.concatenate(found)) for found in off)
    share = updates / (crowd.actors * frames)
    return Saving(
        crowd, all_s, some_s, share, at_once_px, in_time_px, float(parts[1] / max(parts[0], 1))
    )


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


def _act_all(acting: Acting, frames: int, answers: "multiprocessing.connection.Connection") -> None:
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
    before, now = (
        _pose(cast.appearance(parts, weights), len(cut), view)
        for cast, parts in ((shown, cut.parts), (true, there))
    )
    return displacement_px(initial_state(before), now)


def _pose(sticks: Sticks, parts: int, view: View) -> TruePose:
    due = np.zeros(parts, bool)
    return TruePose(sticks.start, sticks.end, sticks.owner, due, view.camera.eye, view.theta)


def _worst(off: Reals) -> tuple[float, float]:
    return float(np.quantile(off, 0.999)), float(off.max())


def saving_rows(found: Sequence[Saving]) -> list[tuple[str, ...]]:
    """Write savings as the rows of a table, its head first."""
    who = "actors", "a m²", "waving", "questions more", "bound px"
    head = (*who, "s, all", "s, some", "saved", "updated")
    px = "at once p99.9", "most px", "in time p99.9", "most px"
    rows: list[tuple[str, ...]] = [(*head, *px, "parts")]
    for each in found:
        crowd = each.crowd
        who = (
            f"{crowd.actors:,}",
            f"{crowd.density:g}",
            "yes" if crowd.waving else "no",
            str(crowd.questions),
            f"{crowd.threshold:g}",
        )
        seconds = f"{each.seconds_all:.1f}", f"{each.seconds_some:.1f}", f"{each.saved:.2f}"
        off = (f"{px:.3f}" for px in (*each.at_once_px, *each.in_time_px))
        rows.append((*who, *seconds, f"{each.updated:.3f}", *off, f"{each.parts_ratio:.4f}"))
    return rows


def verdict_rows(found: Sequence[Saving]) -> list[str]:
    """Judge the aim by either error: of each crowd, the bound that saves most within ``AIM_PX``."""
    crowds: dict[Crowd, list[Saving]] = {}
    for each in found:
        crowds.setdefault(replace(each.crowd, threshold=0.0), []).append(each)
    lines = [
        f"aim: {AIM_TIMES:g} times fewer seconds while 99.9 % of the displayed parts are off by at"
        f" most {AIM_PX:g} px"
    ]
    for crowd, savings in crowds.items():
        more = f", {crowd.questions} questions more" if crowd.questions else ""
        waving = ", waving" if crowd.waving else ""
        lines.append(f"{crowd.actors:,} actors, {crowd.density:g} a m²{more}{waving}:")
        for error in ("at_once_px", "in_time_px"):
            name = error.removesuffix("_px").replace("_", " ")
            lines.append(f"  {name}: {_verdict(savings, error)}")
    return lines


def _verdict(savings: Sequence[Saving], error: str) -> str:
    """Tell whether any of the savings of a crowd reaches the aim by an error."""
    bounds = ", ".join(f"{each.crowd.threshold:g}" for each in savings)
    tried = f"at {'any' if len(savings) > 1 else 'the'} bound tried ({bounds} px)"
    within = [each for each in savings if getattr(each, error)[0] <= AIM_PX]
    if not within:
        least = min(getattr(each, error)[0] for each in savings)
        return f"not reached {tried}: {least:.3f} px off or more"
    best = max(within, key=lambda each: each.saved)
    high, most = getattr(best, error)
    off = f"({high:.3f} px off, most {most:.3f})"
    at = f"{best.saved:.2f} times at a bound of {best.crowd.threshold:g} px {off}"
    return f"reached: {at}" if best.saved >= AIM_TIMES else f"not reached {tried}: {at}"


FPS = 24
_SOUGHT_M = 3.0


@dataclass(frozen=True)
class Clearance:
    """How near any two of the people came to each other [m], and frames in which two overlapped."""

    people: int
    side_m: float
    frames: int
    nearest_m: float
    overlapping: int


@dataclass(frozen=True)
class Feet:
    """How far a foot that stands slides in a frame, mean and 99th percentile, and sinks [mm]."""

    whose: str
    slide_mm: tuple[float, float]
    sink_mm: float


def clearance(people: int, side: float, seconds: float, seed: int) -> Clearance:
    """Let people walk about in a square."""
    frames = round(FPS * seconds)
    least = np.array(list(nearest_m(people, side, frames, seed)))
    overlapping = int((least < 2 * BODY_M).sum())
    return Clearance(people, side, frames, float(least.min()), overlapping)


def nearest_m(people: int, side: float, frames: int, seed: int) -> Iterator[float]:
    """Let people walk about in a square, and give the least distance of two, frame by frame [m]."""
    acting = troupe_of(walkers(people, side, frames, 0.0, seed)).acting
    for _ in range(frames):
        places = acting.act().places[:, (X, Y)]
        yield float(cKDTree(places).query(places, 2)[0][:, 1].min())


@dataclass(frozen=True)
class Meetings:
    """How near actors of a preset come to each other, by the models of the two.

    updated      share of the actors with a behaviour that is updated in a frame
    threshold    of the preset [px]
    nearest_m    by pairs of models, of those within ``_SOUGHT_M`` of each other
    overlapping  frames in which two overlapped
    """

    preset: str
    actors: int
    frames: int
    threshold: float
    updated: float
    nearest_m: dict[str, float]
    overlapping: int


def meetings(name: str, frames: int) -> Meetings:
    """Let the actors of a shipped preset act at its own threshold."""
    preset = load_preset(name, (f"acting.frames={frames}",))
    roles = tuple(preset_roles(preset))
    performance = troupe_of(preset).cast.performance
    nearest: dict[str, float] = {}
    updates = overlapping = 0
    for frame in range(1, frames + 1):
        acted = performance.frame(frame)
        updates += int(acted.updated.sum())
        places, least = acted.places[:, (X, Y)], math.inf
        for a, b in cKDTree(places).query_pairs(_SOUGHT_M):
            apart = float(np.hypot(*(places[a] - places[b])))
            pair = " and ".join(sorted((roles[a].table.model, roles[b].table.model)))
            nearest[pair], least = min(apart, nearest.get(pair, apart)), min(apart, least)
        overlapping += least < 2 * BODY_M
    acting = sum(1 for each in roles if each.table.behaviour)
    share = updates / (acting * frames)
    threshold = preset.acting.threshold
    found = dict(sorted(nearest.items()))
    return Meetings(name, len(roles), frames, threshold, share, found, overlapping)


def feet_of_actors(people: int, side: float, seconds: float, seed: int) -> Feet:
    """Measure the feet of people who act, from when they set off."""
    frames = round(FPS * seconds)
    cast = troupe_of(walkers(people, side, frames, 0.0, seed)).cast
    contacts = []
    for frame in range(1, frames + 1):
        acted = cast.performance.frame(frame)
        who = [
            posed_prototype(prototype, int(place[EIGHTHS]), acted.held.get(k, ()))
            for k, (prototype, place) in enumerate(zip(cast.prototypes, acted.places, strict=True))
        ]
        contacts.append(soles(who, acted.places))
    return _feet(f"actors in {seconds:g} s", np.array(contacts))


def feet_of_the_field(people: int, radius: float, seconds: float, seed: int) -> Feet:
    """Measure the feet of a field's walkers, each on a circle."""
    frames = round(FPS * seconds)
    rng = np.random.default_rng(seed)
    found = model_prototypes("figure", 2, (1.0,), True)
    who = [each for each in found if isinstance(each, RiggedPrototype)] * (people // 2)
    motions = [each.motion for each in who]
    stride, period = (
        np.array([getattr(each, name) for each in motions]) for name in ("stride", "period")
    )
    heading, phase = rng.uniform(0, 2 * np.pi, len(who)), rng.random(len(who))
    orbit = PatrolOrbit(radius, heading, rng.random(len(who)) < 0.5, phase, stride, period)
    contacts = []
    for frame in range(frames):
        now = orbit.at(frame / FPS)
        yaw = np.arctan2(now.sin, now.cos)
        columns = (*now.offset.T, yaw, now.phase, np.ones(len(who)), np.full(len(who), 8.0))
        contacts.append(soles(who, np.column_stack(columns)))
    return _feet("a field's walkers", np.array(contacts))


def soles(who: list[RiggedPrototype], places: np.ndarray) -> np.ndarray:
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


def _feet(whose: str, contacts: np.ndarray) -> Feet:
    """Judge contacts (frames, n, 4, 3)."""
    low = contacts[..., 2].argmin(axis=2)
    moved = np.linalg.norm(np.diff(contacts[..., :2], axis=0), axis=-1)
    moved = np.take_along_axis(moved, low[:-1, :, None], axis=2)[..., 0][low[1:] == low[:-1]]
    slide = float(moved.mean()) * 1e3, float(np.quantile(moved, 0.99)) * 1e3
    return Feet(whose, slide, float(-contacts[..., 2].min()) * 1e3)


def walking_rows(clear: list[Clearance], met: Sequence[Meetings], feet: list[Feet]) -> list[str]:
    """Write what was found as lines."""
    lines = [
        f"{each.people} people in {each.side_m:g} × {each.side_m:g} m for {each.frames / FPS:g} s:"
        f" nearest {each.nearest_m:.3f} m, overlapping in {each.overlapping} of"
        f" {each.frames:,} frames"
        for each in clear
    ]
    for meeting in met:
        near = ", ".join(f"{pair} {m:.3f} m" for pair, m in meeting.nearest_m.items())
        lines += [
            f"{meeting.preset}, {meeting.actors} actors for {meeting.frames / FPS:g} s:"
            f" {100 * meeting.updated:.1f} % updated in a frame, by a bound of"
            f" {meeting.threshold:g} px;",
            f"  nearest {near}; overlapping in {meeting.overlapping} of {meeting.frames:,} frames",
        ]
    for each in feet:
        slides = f"{each.slide_mm[0]:.1f} mm a frame, {each.slide_mm[1]:.1f} mm in the worst 1 %"
        lines.append(f"feet of {each.whose}: slide {slides}; sink {each.sink_mm:.1f} mm at most")
    return lines


_EVERY_S = 0.0005
KINDS: dict[str, tuple[str, ...]] = {
    "quaternions": ("lod.actors.quaternion", "lod.actors.joint", "lod.actors.quaternion"),
    "messages": ("lod.actors",),
    "bodies": ("scenes.actors.body", "scenes.actors.limb", "scenes.actors.limb"),
    "the scene": ("scenes.actors.stage",),
    "behaviours": ("scenes.actors.behaviours",),
    "who is due": ("scenes.actors",),
}
"""What the modules of each name are; the first that fits counts."""


WITHOUT_WAVING = "walk without waving"


@dataclass(frozen=True)
class Costs:
    """Microseconds of an update of an actor, and of the pruner a frame for each actor.

    split  the update's, by kind
    who    what they do
    """

    actors: int
    side_m: float
    update_us: float
    split: dict[str, float]
    prune_us: float
    who: str = WITHOUT_WAVING


@dataclass(frozen=True)
class ByBehaviour:
    """What an update costs by what an actor does, measured in turns."""

    found: list[Costs]


def costs(count: int, side: float, frames: int, seed: int) -> Costs:
    """Measure a crowd in a square, all updated in every frame."""
    preset = walkers(count, side, 3 * frames, 0.0, seed)
    return _in_turns({WITHOUT_WAVING: preset}, side, frames)[0]


def costs_by_behaviour(count: int, side: float, frames: int, seed: int) -> ByBehaviour:
    """Measure actors of every shipped behaviour of bodies, which take turns frame by frame."""
    return ByBehaviour(_in_turns(by_behaviour(count, side, 3 * frames, seed), side, frames))


def _in_turns(presets: Mapping[str, Preset], side: float, frames: int) -> list[Costs]:
    """Time and then sample troupes, each all updated in every frame."""
    troupes = {who: troupe_of(preset) for who, preset in presets.items()}
    seconds, notes = dict.fromkeys(troupes, 0.0), {}
    for frame in range(1, 2 * frames + 1):
        for who, troupe in troupes.items():
            spent = _act(troupe, frame, frame)
            seconds[who] += spent if frame > frames else 0.0  # compiling falls into the first
    for who, troupe in troupes.items():
        with sampled() as notes[who]:
            _act(troupe, 2 * frames + 1, 3 * frames)
    found = []
    for who, troupe in troupes.items():
        count, total = len(troupe.cast.prototypes), max(sum(notes[who].values()), 1)
        whole = 1e6 * seconds[who] / (count * frames)
        split = {kind: whole * notes[who][kind] / total for kind in (*KINDS, "else")}
        prune_us = 1e6 * _prune_s(troupe, presets[who]) / count
        found.append(Costs(count, side, whole, split, prune_us, who))
    return found


def _act(troupe: Troupe, first: int, last: int) -> float:
    start = time.process_time()
    for frame in range(first, last + 1):
        troupe.cast.performance.frame(frame)
    return time.process_time() - start


def _prune_s(troupe: Troupe, preset: Preset) -> float:
    """Time finding, blending and posing what is displayed in the last frame, the least of three."""
    view = Scene(preset).view(preset.acting.frames)
    least = math.inf
    for _ in range(4):  # the first one compiles
        start = time.process_time()
        cut = prune(troupe.cast, view)
        troupe.cast.appearance(cut.parts, blend_weights(cut, view))
        least = min(least, time.process_time() - start)
    return least


@contextmanager
def sampled() -> Iterator[Counter[str]]:
    """Count, while it runs, whose code the processor's clock finds."""
    notes: Counter[str] = Counter()

    def note(number: int, frame: FrameType | None) -> None:
        notes[kind_of(frame)] += 1

    before = signal.signal(signal.SIGPROF, note)
    signal.setitimer(signal.ITIMER_PROF, _EVERY_S, _EVERY_S)
    try:
        yield notes
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def kind_of(frame: FrameType | None) -> str:
    """Tell which kind of work runs in a frame of the stack: of the innermost code of ours."""
    while frame is not None:
        name = frame.f_globals.get("__name__", "")
        for kind, modules in KINDS.items():
            if name.startswith(modules):
                return kind
        frame = frame.f_back
    return "else"


def cost_rows(found: list[Costs]) -> list[tuple[str, ...]]:
    """Write costs as the rows of a table, its head first [µs]."""
    head = "who", "actors", "in a square of", "an update", *KINDS, "else", "pruner, a frame"
    rows: list[tuple[str, ...]] = [head]
    for each in found:
        split = (f"{us:.0f}" for us in each.split.values())
        who = each.who, str(each.actors), f"{each.side_m:.0f} m"
        rows.append((*who, f"{each.update_us:.0f}", *split, f"{each.prune_us:.1f}"))
    return rows
