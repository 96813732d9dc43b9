"""How far do the feet of a gait slide, sink and float on flat ground, between key poses as well?"""

from dataclasses import dataclass

import numpy as np

from lod.arrays import Reals
from scenes.figures.gait import Gait, Leg, heel_and_ball
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.rig.rotations import Quaternions, Vectors, rotate_vectors
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


def foot_slide(prototype: RiggedPrototype, gait: Gait, seen: SampledCycle) -> float:
    """Farthest that heel or ball moves over the ground while the foot rolls over it [m]."""
    worst = 0.0
    for leg in gait.legs:
        heel_until, ball_from = _rolls(leg)
        for side in ("left", "right"):
            row = prototype.rig.row(f"{side} {leg.ankle}")
            own = (seen.phase - leg.strike - (leg.apart if side == "right" else 0.0)) % 1.0
            stances = (own < min(heel_until, gait.duty), (own >= ball_from) & (own < gait.duty))
            for (x, z, _), stands in zip(heel_and_ball(prototype, row), stances, strict=True):
                point = np.array((x, 0.0, z))
                path = _placed(seen.origin[stands, row], seen.facing[stands, row], point)[:, :2]
                path[:, 0] += prototype.motion.stride * own[stands]
                if len(path):
                    worst = max(worst, float(np.linalg.norm(np.ptp(path, axis=0))))
    return worst


def _rolls(leg: Leg) -> tuple[float, float]:
    """Phases until which the heel, and from which the ball, is the contact that stays: flat is
    both.
    """
    flat = [phase for phase, degrees in leg.pitch if degrees == 0.0 and phase < 0.6]
    return (max(flat), min(flat)) if flat else (0.0, 1.0)


def _placed(origin: Vectors, facing: Quaternions, point: Vectors) -> Vectors:
    return origin + rotate_vectors(facing, np.broadcast_to(point, origin.shape))
