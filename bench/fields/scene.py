"""What does a case of the scaling experiment look at? Objects, ground and view."""

import hashlib
import json
from dataclasses import replace
from functools import lru_cache

import numpy as np

from bench.fields.cases import Case
from lod.air import Air, least_extinction
from lod.camera import Corner, camera_from_heading
from lod.view import View
from lod.viewing import BlurWidths, ViewingConditions
from scenes.figures.person import standing_people
from scenes.grass.sward import tuft_prototypes
from scenes.ground.terrain import Terrain
from scenes.models.stone import boulder_prototypes
from scenes.plugins import metric_by_name
from scenes.sticks.prototype import Prototype
from scenes.trees.species import tree_species
from scenes.trees.tree import tree_prototypes

FLAT = Terrain(seed=0, amplitude=0.0, wavelength=1024.0, hurst=1.0, reach=1000.0)


KEPT = {"evenly": 1.0, "patches": 0.25, "slope": 0.5, "clearing": 1.0}
"""The share of an even field that is left: of patches, at the eye, or at a clearing's edge."""

HILLS_M = 512.0
"""The longest wave of hilly ground [m]."""

_STANDING = {
    "figure": lambda: standing_people(0, 4),
    "tree": lambda: tree_prototypes(0, 2, tree_species("tree")),
    "boulder": lambda: boulder_prototypes(0, 2),
    "sward": lambda: tuft_prototypes(0, 2),
}
"""The prototypes of each species, all equally likely; nothing moves."""


@lru_cache(maxsize=64)
def prototypes_of(species: str, size: float) -> tuple[Prototype, ...]:
    """Return the species' prototypes, ``size`` times as large."""
    return tuple(each.scaled(size) for each in _STANDING[species]())


def field_seed(*words: object) -> int:
    """Return the seed, in 63 bits, of a field that is named by plain data."""
    text = json.dumps(words, sort_keys=True)
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big") >> 1


def ground_of(case: Case) -> Terrain:
    """Return flat ground, or the same hills for all fields of a case."""
    return replace(FLAT, amplitude=case.hills, wavelength=HILLS_M, hurst=0.8)


def view_of(case: Case) -> View:
    """Return the view from the middle of the world, all round."""
    ground = float(ground_of(case).height(Corner(0, 0), np.zeros((1, 2)))[0])
    eye = np.array((0.0, 0.0, ground + case.eye_height))
    camera = camera_from_heading(Corner(0, 0), eye, 0.0, 0.0, case.fov, (case.width, 1))
    sight = None
    if case.visibility is not None:
        sight = ViewingConditions(
            BlurWidths(camera.pixel_angle), least_extinction(Air(case.visibility))
        )
    return View(
        camera, metric_by_name(case.metric), case.detail, look_around=True, conditions=sight
    )
