"""Counting one field of a case, by the real field and the real pruner."""

import hashlib
import json

import numpy as np

from bench.sampling import Row
from bench.scaling_cases import EYE_HEIGHT_M, Case
from bench.scaling_law import prototypes_of
from lod.camera import Corner, look
from lod.prune import prune
from lod.view import View
from scenes.field import Species, SpeciesField
from scenes.plugins import metric_named
from scenes.terrain import Terrain

COLUMNS = ("objects", "parts", "objects_examined", "parts_examined")
"""What is counted in a field: displayed and examined, in the order of a row."""

FLAT = Terrain(seed=0, amplitude=0.0, wavelength=1024.0, hurst=1.0, reach=1000.0)


def count_field(case: Case, seed: int) -> Row:
    """The counts of one field, in the order of COLUMNS."""
    species = Species(case.species, prototypes_of(case.species, case.size), case.density)
    cut = prune(SpeciesField(species, seed, FLAT, case.extent), view_of(case))
    return cut.displayed_objects, cut.displayed_parts, cut.examined_objects, cut.examined_parts


def view_of(case: Case) -> View:
    """From the middle of the world, all round."""
    eye = np.array((0.0, 0.0, EYE_HEIGHT_M))
    camera = look(Corner(0, 0), eye, 0.0, 0.0, case.fov, (case.width, 1))
    return View(camera, metric_named(case.metric), case.detail, look_around=True)


def seed_of(case: Case, seed: int, index: int) -> int:
    """A field's own seed, in 63 bits, independent for every case, run seed and index."""
    text = json.dumps([case.as_json(), seed, index], sort_keys=True)
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big") >> 1


def scene_hash(cases: tuple[Case, ...]) -> str:
    """SHA-256 of every case and of every prototype's hierarchy: what was measured."""
    digest = hashlib.sha256(json.dumps([case.as_json() for case in cases], sort_keys=True).encode())
    for species in sorted({case.species for case in cases}):
        for prototype in prototypes_of(species, 1.0):
            tree = prototype.hierarchy
            for name in ("whole", "level", "position", "P", "R", "B", "separation"):
                digest.update(np.ascontiguousarray(getattr(tree, name)).tobytes())
    return digest.hexdigest()
