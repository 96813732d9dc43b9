"""Where the objects of a species stand at a time: homes, patrols, and feet on the ground."""

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Reals
from lod.pruning.view import View
from scenes.field.ground_contact_detail import ground_contact_detail
from scenes.field.poisson_cells import CellSamples
from scenes.field.posed_species import SpeciesPrototypes
from scenes.field.species import Species
from scenes.gait.patrol import PatrolOrbit, stride_factors
from scenes.rig.foot_placement import Heights, Placements, place_on_ground
from scenes.rig.pose_tables import Instances


def patrol_orbits(
    species: Species, prototypes: SpeciesPrototypes, samples: CellSamples
) -> tuple[Ints, Reals, PatrolOrbit]:
    """Draw prototype and stride (a share of that one's) of each object, and how it goes round,
    (n,).

    All three follow from the object's own uniform numbers.
    """
    u = samples.u
    prototype = (u[:, 3] * len(species.prototypes)).astype(np.int64)
    motions = [each.motion for each in prototypes.rigged]
    stride, period = (np.array([getattr(m, k) for m in motions]) for k in ("stride", "period"))
    stride_factor, tempo = stride_factors(u[:, 6])
    orbits = PatrolOrbit(
        species.patrol_m or 1.0,  # what has no patrol has no stride either
        2 * np.pi * u[:, 2],
        u[:, 5] < 0.5,
        u[:, 4],
        stride[prototype] * stride_factor * (species.patrol_m > 0),
        period[prototype] * np.where(stride[prototype] > 0, tempo, 1.0),
    )
    return prototype, stride_factor, orbits


def place_instances(
    species: Species,
    prototypes: SpeciesPrototypes,
    heights: Heights,
    homes: Float64[np.ndarray, "n 2"],
    samples: CellSamples,
    time_s: float,
    view: View | None = None,
) -> Instances:
    """Compute how the objects of a species stand at a time [s].

    heights: of the ground at points of the frame [m]; homes (n, 2) in the frame [m]
    view: feet meet the ground as closely as it could show; None = as closely as they can
    """
    prototype, stride_factor, orbits = patrol_orbits(species, prototypes, samples)
    walkers = orbits.at(time_s)
    xy = homes + walkers.offset
    facing, phase = (walkers.cos, walkers.sin), walkers.phase
    placements = Placements(xy, *facing, prototype, phase, stride_factor)
    if view is not None:
        detail = ground_contact_detail(prototypes, view, xy, prototype)
        placements = placements._replace(contact_detail=detail)
    return place_on_ground(prototypes.pose_tables, heights, placements)
