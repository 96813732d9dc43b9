"""How far do the feet of a gait slide, sink and float on flat ground, between key poses as well?"""

from dataclasses import dataclass

import numpy as np

from lod.arrays import Reals
from scenes.rig.rig import Quaternions, Vectors, rotate_vectors
from scenes.rig.rigged_prototype import RiggedPrototype
from tests.scenes.figures.motion_phase import motion_at


@dataclass(frozen=True, eq=False)
class SampledCycle:
    """One cycle at K phases: turns (K, j, 4) in the parents; origin (K, j, 3), facing (K, j, 4)
    of joints.
    """

    phase: np.ndarray
    rotations: np.ndarray
    origin: np.ndarray
    facing: np.ndarray


def sample_cycle(prototype: RiggedPrototype, count: int = 240) -> SampledCycle:
    """One cycle of the motion at evenly spaced phases that are not those of keys."""
    phase = (np.arange(count) + 0.37) / count
    poses = [motion_at(prototype.motion, float(p)) for p in phase]
    rotations, shift = (np.array(column) for column in zip(*poses, strict=True))
    return SampledCycle(phase, rotations, *prototype.rig.frames(rotations, shift))


def lowest_heights(prototype: RiggedPrototype, seen: SampledCycle) -> Reals:
    """Height of the lowest point of any stick at each phase, (K,) [m]."""
    low = np.full(len(seen.phase), np.inf)
    for table in prototype.full_detail_sticks():
        ends = (
            (table.start_joint, table.start, table.start_radius),
            (table.end_joint, table.end, table.end_radius),
        )
        for joint, point, radius in ends:
            if len(joint):
                at = _placed(seen.origin[:, joint], seen.facing[:, joint], point)
                low = np.minimum(low, (at[..., 2] - radius).min(axis=1))
    return low


def _placed(origin: Vectors, facing: Quaternions, point: Vectors) -> Vectors:
    return origin + rotate_vectors(facing, np.broadcast_to(point, origin.shape))
