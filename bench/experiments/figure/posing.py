"""What does posing cost by quaternions, and what by matrices? (§3.3)

Both are given the turns of all joints in their own form and place the same points. Times are those
of one thread's processor; the two take turns, so that what else the machine does slows both.
"""

import time
from typing import Any

import numpy as np

from bench.experiments.figure.cases import PERSON, POINTS_PER_JOINT, object_of
from bench.experiments.figure.posing_kernels import placed_by_matrices, placed_by_quaternions
from scenes.rig.rotations import matrices


def posing(
    task: str, poses: int, repeats: int, seed: int
) -> tuple[dict[str, Any], dict[str, list[int]]]:
    """Pose the person both ways in turns, and time it; the first of each compiles and is left out.

    Returns what was posed: ``poses`` in each repeat, ``joints`` and ``points`` of each pose, and
    ``apart_m``, the greatest difference between what the two placed [m]; and the times of every
    repeat, ``quaternions_ns`` and ``matrices_ns``.
    """
    rig = object_of(PERSON).rig
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, 0xC057))))
    turns = rig.random_turns(rng, poses)
    points = rng.uniform(-0.2, 0.2, (len(rig), POINTS_PER_JOINT[task], 3))
    both = (placed_by_quaternions, turns), (placed_by_matrices, matrices(turns))
    first, second = (kernel(rig.parent, rig.offset, form, points) for kernel, form in both)
    apart = float(np.abs(first - second).max(initial=0.0))
    times: list[list[int]] = [[], []]
    for repeat in range(repeats):
        for k in (0, 1) if repeat % 2 else (1, 0):
            kernel, form = both[k]
            start = time.thread_time_ns()
            kernel(rig.parent, rig.offset, form, points)
            times[k].append(time.thread_time_ns() - start)
    sizes = {"poses": poses, "joints": len(rig), "points": points.size // 3, "apart_m": apart}
    return sizes, {"quaternions_ns": times[0], "matrices_ns": times[1]}
