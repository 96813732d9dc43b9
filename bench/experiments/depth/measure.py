"""How many surfaces does a ray pierce on its way to the limit? (§4.1)

Level rays all round are tested against every stick that is displayed: a line pierces a stick when a
point of its axis is nearer to the line than the radius there. Pruned, the count should depend
neither on the size of the world nor on the direction; unpruned, it grows with the world's radius.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from numba import njit

from bench.experiments.depth.claims import QUADRANTS
from bench.fields.part_sizes import camera, prototypes_with, seed_of
from bench.fields.scene import FLAT
from bench.old_experiment import Effort
from bench.records.records import Column, Point
from lod.arrays import Ints
from lod.crossfade import blend_weights
from lod.metric import METRICS
from lod.pruner import prune
from lod.shapes import Sticks
from lod.view import View
from scenes.field.species_field import Species, SpeciesField

EXTENTS_M = (75.0, 150.0, 300.0, 450.0)
DENSITY = 4e-3
DETAIL_PX, WIDTH_PX = 4.0, 320
"""Detail and width of the picture [px]: a person is displayed within some 130 m."""

RAYS = 32
"""The number of rays in each quadrant; they are even, and the first direction is random."""

EYE_M = 1.2
"""Height of the rays [m], at which they meet chests and arms."""


@dataclass(frozen=True)
class Case:
    """A side of the world [m], the metric that prunes it, and how many fields are measured."""

    extent: float
    metric: str
    fields: int


def cases(effort: Effort) -> list[Case]:
    """Return every extent, pruned and unpruned."""
    return [Case(e, m, effort["fields"]) for e in EXTENTS_M for m in ("blake", "full")]


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, int]:
    """Return the number of fields, and of rays in each quadrant."""
    return {**effort.sizes, "rays_in_a_quadrant": RAYS}


def measure(case: Case, seed: int) -> Point:
    """Count the sticks that rays pierce in every field of one extent."""
    rows = np.array([count(case.extent, case.metric, seed, k) for k in range(case.fields)])
    pierced = (Column("pierced", rows[:, k].tolist(), {"quadrant": k}) for k in range(QUADRANTS))
    return Point({"extent": case.extent, "metric": case.metric}, samples=tuple(pierced))


def count(extent: float, metric: str, seed: int, index: int) -> list[int]:
    """Count the sticks that all rays of each quadrant together pierce, in one field."""
    view = View(camera(WIDTH_PX), METRICS[metric], DETAIL_PX, look_around=True)
    own = seed_of("depth", seed, index)
    species = Species("depth", prototypes_with("figure", None), DENSITY)
    field = SpeciesField(species, own, FLAT, extent)
    cut = prune(field, view)
    shape = field.prototypes.sticks(cut.parts, blend_weights(cut, view))
    eye = np.array((view.camera.eye[0], view.camera.eye[1], EYE_M))
    turn = np.random.Generator(np.random.Philox(own)).random()
    angle = (np.arange(QUADRANTS * RAYS) + turn) * math.tau / (QUADRANTS * RAYS)
    rays = np.stack((np.cos(angle), np.sin(angle), np.zeros(len(angle))), axis=1)
    found: list[int] = pierced(shape, eye, rays).reshape(QUADRANTS, RAYS).sum(axis=1).tolist()
    return found


def pierced(shape: Sticks, eye: Float64[np.ndarray, "3"], rays: Float64[np.ndarray, "r 3"]) -> Ints:
    """Count the sticks that each ray from the eye pierces, (r,)."""
    columns = shape.start - eye, shape.end - eye, shape.start_radius, shape.end_radius
    return _pierced(*(np.ascontiguousarray(each) for each in columns), rays)


@njit(cache=True)
def _pierced(start, end, r0, r1, rays):  # type: ignore[no-untyped-def]
    found = np.zeros(len(rays), np.int64)
    for i in range(len(r0)):
        ax, ay, az = start[i, 0], start[i, 1], start[i, 2]
        ux, uy, uz = end[i, 0] - ax, end[i, 1] - ay, end[i, 2] - az
        k = r1[i] - r0[i]
        # All of it lies within a sphere about its middle.
        mx, my, mz = ax + ux / 2, ay + uy / 2, az + uz / 2
        reach = math.sqrt(ux * ux + uy * uy + uz * uz) / 2 + max(r0[i], r1[i])
        away = mx * mx + my * my + mz * mz - reach * reach
        for j in range(len(rays)):
            dx, dy, dz = rays[j, 0], rays[j, 1], rays[j, 2]
            ahead = mx * dx + my * dy + mz * dz
            if ahead + reach < 0 or away > ahead * ahead:
                continue
            # |w + t·v|² − (r₀ + t·k)² across the ray is least at t, 0 to 1.
            a, u = ax * dx + ay * dy + az * dz, ux * dx + uy * dy + uz * dz
            wx, wy, wz = ax - a * dx, ay - a * dy, az - a * dz
            vx, vy, vz = ux - u * dx, uy - u * dy, uz - u * dz
            square = vx * vx + vy * vy + vz * vz - k * k
            slope = wx * vx + wy * vy + wz * vz - r0[i] * k
            t = min(max(-slope / square, 0.0), 1.0) if square > 0 else (1.0 if k > 0 else 0.0)
            off = (wx + t * vx) ** 2 + (wy + t * vy) ** 2 + (wz + t * vz) ** 2
            if off <= (r0[i] + t * k) ** 2 and a + t * u > 0:
                found[j] += 1
    return found
