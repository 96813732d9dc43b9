"""Does an object ever consist of many more parts than the pixels that it covers? (§4.1)

Each displayed object of a field is drawn alone, so that nothing hides it: every stick is the hull
of two discs on the picture plane, sampled at FINENESS² places of each pixel. A pixel is covered
when any of its places is; ``area`` counts the places themselves.
"""

from functools import partial

import numpy as np

from bench.counting import FLAT
from bench.experiment import Case
from bench.part_sizes import camera, density_of, prototypes_with, seed_of
from bench.records.records import Point, columns
from lod.arrays import Ints, Reals
from lod.pruner import blend_weights, prune
from lod.shapes import StickTable
from lod.view import View
from scenes.appearance.visible_area import first_met
from scenes.field.species_field import Species, SpeciesField
from scenes.plugins import metric_by_name

MOST = 4.0  # the ratio that at most 5 % of the objects may exceed

SPECIES = ("figure", "tree")
METRICS_TRIED = ("blake", "bounded", "solid_angle")
DETAILS = (1.0, 4.0)
FINENESS = 4  # the places that are sampled along each side of a pixel

WIDTH_PX = 640
THINNER = 1 / 2  # density ÷ that of the experiments on haze and eye: a thousand objects are enough

NEAREST = 2.0
"""The distance, in bounds of an object, below which it is left out: it is about the eye."""


def cases(objects: int, metric: str | None = None) -> list[Case]:
    """Return every species by every metric and detail; ``metric`` is one of them."""
    metrics = (*METRICS_TRIED, *([metric] if metric else []))
    return [partial(measure, s, m, d, objects) for s in SPECIES for m in metrics for d in DETAILS]


def measure(species: str, metric: str, detail: float, objects: int, seed: int) -> Point:
    """Measure parts, pixels and area of at most so many objects of one field."""
    named = {"topic": "pixels", "species": species, "metric": metric, "detail": detail}
    return Point(named, samples=columns(drawn(species, metric, detail, objects, seed)))


def drawn(species: str, metric: str, detail: float, most: int, seed: int) -> dict[str, list[int]]:
    """Measure up to ``most`` displayed objects of one field, chosen at random.

    Gives columns over objects: parts, pixels covered, and area in thousandths of a pixel.
    """
    view = View(camera(WIDTH_PX), metric_by_name(metric), detail, look_around=True)
    density = THINNER * density_of(species, view.m)
    kind = Species("pixels", prototypes_with(species, None), density)
    field = SpeciesField(kind, seed_of(f"pixels {species}", seed, 0), FLAT)
    cut = prune(field, view)
    parts, weights = cut.parts, blend_weights(cut, view)
    roots = np.flatnonzero(parts.parent < 0)
    offset = parts.position[roots] - view.camera.eye
    roots = roots[np.linalg.norm(offset, axis=1) > NEAREST * parts.bound[roots]]
    rng = np.random.Generator(np.random.Philox(seed))
    chosen = np.sort(rng.permutation(parts.object[roots])[:most])
    rows = np.flatnonzero(np.isin(parts.object, chosen))
    shape = field.prototypes.sticks(parts.take(rows), weights.take(rows))
    count = np.bincount(parts.object[rows])[chosen]
    owner = parts.object[rows][shape.owner]
    order = np.argsort(owner, kind="stable")
    ends = np.searchsorted(owner[order], [chosen, chosen + 1])
    columns_ = shape.start, shape.end, shape.start_radius, shape.end_radius
    found = []
    for a, b in ends.T:  # the sticks of each object follow each other
        sticks = tuple(np.asarray(each[order[a:b]]) for each in columns_)
        found.append(covered(sticks, view, rng.integers(0, FINENESS, 2)))
    pixels, area = zip(*found, strict=True)
    thousandths = [round(1000 * each) for each in area]
    return {"parts": count.tolist(), "pixels": list(pixels), "area": thousandths}


def covered(sticks: tuple[np.ndarray, ...], view: View, phase: Ints) -> tuple[int, float]:
    """Count the pixels that sticks cover, seen alone and aimed at, and their area [px].

    ``phase`` (2,) is where the grid of pixels begins, in sampled places.
    """
    start, end, start_radius, end_radius = sticks
    eye, theta = view.camera.eye, view.camera.pixel_angle
    towards = (start + end).mean(axis=0) / 2 - eye
    towards = towards / np.linalg.norm(towards)
    across = np.cross(towards, (0.0, 0.0, 1.0))
    across = across / np.linalg.norm(across)
    axes = np.stack((across, np.cross(across, towards)), axis=1)
    ends, radii = [], []
    for place, radius in ((start, start_radius), (end, end_radius)):
        depth = (place - eye) @ towards
        flat = (place - eye) @ axes / (depth * theta)[:, None]
        ends.append(np.column_stack((flat, -depth)))
        radii.append(radius / (depth * theta))
    n = len(start)
    zero = np.zeros(n, np.int64)
    table = StickTable.of(1, zero, ends[0], ends[1], radii[0], radii[1], zero)
    seen = first_met(table, np.array((0.0, 0.0, 1.0)), 1 / FINENESS, -1) >= 0
    padding = [
        (int(p), int(-(p + side) % FINENESS)) for p, side in zip(phase, seen.shape, strict=True)
    ]
    padded = np.pad(seen, padding)
    blocks = padded.reshape(padded.shape[0] // FINENESS, FINENESS, -1, FINENESS)
    return int(blocks.any(axis=(1, 3)).sum()), float(seen.sum()) / FINENESS**2


def ratios(point: Point) -> Reals:
    """Return parts ÷ pixels of every object that covers any."""
    parts, covered = (point.values(k) for k in ("parts", "pixels"))
    return parts[covered > 0] / covered[covered > 0]
