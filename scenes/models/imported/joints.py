"""Joints of an imported model: where its parts turn, about which axis, and how.

Each joint sits at the origin of its node and turns about one axis; its frame is that of the object
as it rests. All that turns keeps to one period, in which it makes whole turns, or swings once.
"""

import numpy as np

from lod.arrays import Ints
from scenes.model_files.part_tree import PartTree
from scenes.rig.keyframes import Motion, rest_motion
from scenes.rig.rig import Rig

_KEYS_A_TURN, _KEYS_A_SWING = 8, 24
"""Key poses: between two of them a joint turns by less than half a turn, the shorter way."""


def joints_of(tree: PartTree) -> tuple[Rig, Ints]:
    """Make the rig of a model, and find the joint of each part, (n,), −1 for the object's frame."""
    joint = np.full(len(tree), -1)
    names, parent, origin = [], [], []
    for row, above in enumerate(tree.parent.tolist()):
        joint[row] = joint[above] if above >= 0 else -1
        if np.any(tree.axis[row]):
            names.append(tree.names[row])
            parent.append(joint[row])
            origin.append(tree.frame[row, :3, 3])
            joint[row] = len(names) - 1
    places = np.array(origin).reshape(-1, 3)
    above_it = np.array(parent, np.int64)
    before = np.concatenate((np.zeros((1, 3)), places))[above_it + 1]
    rest = np.tile((0.0, 0.0, 0.0, 1.0), (len(names), 1))
    most = np.full((len(names), 3), 180.0)
    still = np.zeros(3)
    rig = Rig(tuple(names), above_it, places - before, rest, -most, most, still, still)
    return rig, joint


def motion_of(tree: PartTree, rig: Rig) -> Motion:
    """Make the motion of a model: every joint turns evenly, or swings as a sine."""
    rows = np.flatnonzero(tree.axis.any(axis=1))
    if not len(rows):
        return rest_motion(rig)
    turns, swing = tree.turns[rows], np.radians(tree.swing[rows])
    keys = max(_KEYS_A_TURN * int(np.abs(turns).max()), _KEYS_A_SWING)
    phase = 2 * np.pi * np.arange(keys)[:, None] / keys
    angle = np.where(swing > 0, swing * np.sin(phase), turns * phase)
    linear = tree.frame[rows, :3, :3]
    axis = np.einsum("jab,jb->ja", linear, tree.axis[rows])
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    rotations = np.concatenate(
        (np.sin(angle / 2)[..., None] * axis, np.cos(angle / 2)[..., None]), axis=-1
    )
    return Motion(rotations, np.zeros((keys, 3)), 0.0, tree.period)
