"""How many parts of one object are displayed, in random poses, from random directions?"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from bench.experiments.figure.cases import EVERYTHING, Curve, Distances, looked_from, object_of
from bench.experiments.figure.claims import COUNTED
from bench.records.provenance import scene_digest
from bench.records.records import Point, grouped, where
from lod.arrays import Reals, freeze
from scenes.rig.rigged_prototype import RiggedPrototype

Counts = Int64[np.ndarray, "distances poses"]
Limits = Float64[np.ndarray, " parts"]
Eyes = Float64[np.ndarray, "poses 3"]

UM_PER_M = 1e6


@dataclass(frozen=True, eq=False)
class Approaches:
    """Poses of one object, each looked at from a direction of its own.

    origins     (poses, parts, 3) of its parts, from the origin of the whole object [m]
    directions  (poses, 3) unit vectors from that origin to the eye
    """

    origins: np.ndarray
    directions: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, origins=np.float64, directions=np.float64)


def approaches(thing: RiggedPrototype, poses: int, rng: np.random.Generator) -> Approaches:
    """Draw poses within the joint limits, and directions even over the sphere."""
    origin, _ = thing.rig.frames(thing.rig.random_turns(rng, poses))
    origin = origin[:, thing.joint]
    directions = rng.normal(size=(poses, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return Approaches(origin - origin[:, :1], directions)


def displayed_parts(seen: Approaches, limits: Limits, distances: Distances) -> Counts:
    """Count the parts nearer than their limit, at each distance in each pose."""
    rows = [_displayed(seen, limits, seen.directions * far[:, None]) for far in distances]
    return np.stack(rows)


def _displayed(seen: Approaches, limits: Limits, eye: Eyes) -> Int64[np.ndarray, " poses"]:
    far = np.linalg.norm(eye[:, None] - seen.origins, axis=-1)
    return np.count_nonzero(far < limits, axis=1)


def count(curve: Curve, poses: int, distances: Reals, seed: int) -> Counts:
    """Count one curve; every metric and detail of a kind has the same poses and directions."""
    chance = np.random.SeedSequence((seed, EVERYTHING.index(curve.kind)))
    rng = np.random.Generator(np.random.Philox(chance))
    thing = object_of(curve.kind)
    from_where = looked_from(distances, poses)
    return displayed_parts(approaches(thing, poses, rng), curve.limits, from_where)


def sizes(kind: str) -> dict[str, list[int]]:
    """Return level, whole and P [µm] of every part, as columns."""
    tree = object_of(kind).hierarchy
    P_um = np.rint(tree.P * UM_PER_M).astype(np.int64)
    return {"level": tree.level.tolist(), "whole": tree.parent.tolist(), "P_um": P_um.tolist()}


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of every curve, and of the hierarchy and joints of every kind."""
    counted = grouped(where(points, what=COUNTED), "kind", "metric", "detail")
    curves = [Curve(*each) for each in counted]
    arrays: list[np.ndarray] = []
    for kind in sorted({curve.kind for curve in curves}):
        thing = object_of(kind)
        names = ("parent", "level", "position", "P", "R", "B", "separation")
        arrays += [getattr(thing.hierarchy, name) for name in names] + [thing.joint]
        arrays += [getattr(thing.rig, name) for name in ("parent", "offset", "rest", "low", "high")]
    return scene_digest([curve.as_json() for curve in curves], arrays)
