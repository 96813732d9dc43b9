"""What does posing cost by quaternions, and what by rotation matrices? (§3.3)

The paper takes quaternions to be the cheaper, having no redundant terms. Both kernels do the same
work: they multiply the turn of each joint into that of its parent, turn and add its offset, and
place some points of each joint. They agree to rounding. Times are those of one thread's processor;
the two take turns, so that what else the machine does slows both.
"""

import time

import numpy as np

from lod.kernels import njit
from scenes.rig.rig import Rig, matrices, quaternion_product, rotate_vector


def posing_times(
    rig: Rig, poses: int, points_per_joint: int, repeats: int, seed: int
) -> tuple[float, dict[str, list[int]]]:
    """Pose a rig both ways in turns, and time it; the first of each compiles and is left out.

    Returns the greatest difference between what the two placed [m], and the times of every repeat,
    ``quaternions_ns`` and ``matrices_ns``.
    """
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, 0xC057))))
    turns = rig.random_turns(rng, poses)
    points = rng.uniform(-0.2, 0.2, (len(rig), points_per_joint, 3))
    both = (_by_quaternions, turns), (_by_matrices, matrices(turns))
    first, second = (kernel(rig.parent, rig.offset, form, points) for kernel, form in both)
    apart = float(np.abs(first - second).max(initial=0.0))
    times: list[list[int]] = [[], []]
    for repeat in range(repeats):
        for k in (0, 1) if repeat % 2 else (1, 0):
            kernel, form = both[k]
            start = time.thread_time_ns()
            kernel(rig.parent, rig.offset, form, points)
            times[k].append(time.thread_time_ns() - start)
    return apart, {"quaternions_ns": times[0], "matrices_ns": times[1]}


# Both place the points (j, p, 3) of every joint of n poses, (n, j, p, 3); with p = 0 joints are
# composed alone.


@njit(cache=True)
def _by_quaternions(parent, offset, turns, points):  # type: ignore[no-untyped-def]
    n, j, p = len(turns), len(parent), points.shape[1]
    out = np.empty((n, j, p, 3))
    at, q = np.zeros((j + 1, 3)), np.zeros((j + 1, 4))
    q[0, 3] = 1.0
    for o in range(n):
        for k in range(j):
            up, me = parent[k] + 1, k + 1
            ux, uy, uz, uw = q[up, 0], q[up, 1], q[up, 2], q[up, 3]
            x, y, z = rotate_vector(ux, uy, uz, uw, offset[k, 0], offset[k, 1], offset[k, 2])
            at[me, 0], at[me, 1], at[me, 2] = at[up, 0] + x, at[up, 1] + y, at[up, 2] + z
            ux, uy, uz, uw = quaternion_product(
                ux, uy, uz, uw, turns[o, k, 0], turns[o, k, 1], turns[o, k, 2], turns[o, k, 3]
            )
            q[me, 0], q[me, 1], q[me, 2], q[me, 3] = ux, uy, uz, uw
            for i in range(p):
                x, y, z = rotate_vector(
                    ux, uy, uz, uw, points[k, i, 0], points[k, i, 1], points[k, i, 2]
                )
                out[o, k, i, 0] = at[me, 0] + x
                out[o, k, i, 1] = at[me, 1] + y
                out[o, k, i, 2] = at[me, 2] + z
    return out


@njit(cache=True)
def _by_matrices(parent, offset, matrices, points):  # type: ignore[no-untyped-def]
    n, j, p = len(matrices), len(parent), points.shape[1]
    out = np.empty((n, j, p, 3))
    at, r = np.zeros((j + 1, 3)), np.zeros((j + 1, 3, 3))
    for c in range(3):
        r[0, c, c] = 1.0
    for o in range(n):
        for k in range(j):
            up, me = parent[k] + 1, k + 1
            x, y, z = offset[k, 0], offset[k, 1], offset[k, 2]
            for c in range(3):
                a, b, d = r[up, c, 0], r[up, c, 1], r[up, c, 2]
                at[me, c] = at[up, c] + a * x + b * y + d * z
                for e in range(3):
                    r[me, c, e] = (
                        a * matrices[o, k, 0, e]
                        + b * matrices[o, k, 1, e]
                        + d * matrices[o, k, 2, e]
                    )
            for i in range(p):
                x, y, z = points[k, i, 0], points[k, i, 1], points[k, i, 2]
                for c in range(3):
                    out[o, k, i, c] = (
                        at[me, c] + r[me, c, 0] * x + r[me, c, 1] * y + r[me, c, 2] * z
                    )
    return out
