"""Do people who walk about keep clear of each other, and do their feet stand still?

Feet are held against those of a field's walkers, who go round in circles
(``scenes.figures.patrol``), by the same measure: of the heels and balls of both feet the lowest
stands on the ground, as walkers always have a foot on it. How far does it go over the ground from
one frame to the next, if it is the lowest in both, and how far is any below the ground?
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from bench.studies.acting.crowd import troupe_of, walkers
from scenes.actors.behaviours import BODY_M
from scenes.actors.performance import EIGHTHS, PHASE, STRIDE_FACTOR, YAW, X, Y, posed_prototype
from scenes.field.prototypes import species_prototypes
from scenes.figures.gait import heel_and_ball
from scenes.figures.patrol import PatrolOrbit
from scenes.models.catalogue import model_prototypes
from scenes.preset.load import load_preset
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose import pose_points
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.world.cast import preset_roles

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
