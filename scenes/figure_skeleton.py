"""Where a figure's joints are in a pose, and its parts and sticks on both sides of the body."""

from typing import NamedTuple

import numpy as np

from scenes.figure_tables import (
    SIDE_JOINTS,
    SIDE_PARTS,
    TRUNK_JOINTS,
    TRUNK_PARTS,
    Joint,
    Part,
    Rod,
)

SIDES = {"left": 1.0, "right": -1.0}
Pose = dict[str, tuple[float, float, float]]
Table = dict[str, list[Rod]]


class Frame(NamedTuple):
    """A joint as posed: its origin (3,) and the rotation body_from_joint (3, 3)."""

    origin: np.ndarray
    turn: np.ndarray


def skeleton(pose: Pose, stretch: dict[str, float]) -> dict[str, Frame]:
    """Every joint in the body's frame, shares of stature.

    pose: degrees about x, y, z of joints, keyed "elbow" (both sides alike) or "left elbow"
    stretch: factors on how far out to the side a joint sits
    """
    frames = {"": Frame(np.zeros(3), np.eye(3))}
    for name, joint in both_sides(TRUNK_JOINTS, SIDE_JOINTS).items():
        side, bare = side_of(name)
        x, y, z = joint.offset
        parent = frames[joint.parent]
        offset = parent.turn @ np.array((x, side * y * stretch.get(bare, 1.0), z))
        angles = pose.get(name, pose.get(bare, (0.0, 0.0, 0.0)))
        frames[name] = Frame(parent.origin + offset, parent.turn @ _rotation(angles, side))
    return frames


def parts() -> dict[str, Part]:
    """Every part of a figure by name, wholes before their parts."""
    return both_sides(TRUNK_PARTS, SIDE_PARTS)


def both_sides(trunk: dict, side: dict) -> dict:
    """The trunk's entries, then those of the left side, then their mirror images on the right."""
    named = dict(trunk)
    for hand in SIDES:
        for name, entry in side.items():
            named[f"{hand} {name}"] = _sided(entry, hand)
    return named


def side_of(name: str) -> tuple[float, str]:
    """+1 on the left and in the middle, −1 on the right; and the name without its side."""
    hand, _, bare = name.partition(" ")
    return (SIDES[hand], bare) if hand in SIDES else (1.0, name)


def _sided(entry, hand: str):  # type: ignore[no-untyped-def]
    """The entry with its references to joints and parts of the same side renamed."""

    def rename(reference: str) -> str:
        return f"{hand} {reference}" if reference in SIDE_JOINTS | SIDE_PARTS else reference

    if isinstance(entry, Joint):
        return entry._replace(parent=rename(entry.parent))
    if isinstance(entry, Part):
        return entry._replace(whole=rename(entry.whole), joint=rename(entry.joint))
    return [rod._replace(joint=rename(rod.joint)) for rod in entry]


def _rotation(degrees: tuple[float, float, float], side: float) -> np.ndarray:
    """Rz·Ry·Rx; on the right x and z turn the other way, so that the pose is its mirror image."""
    a, b, c = np.radians(degrees) * (side, 1.0, side)
    rx = np.array(((1, 0, 0), (0, np.cos(a), -np.sin(a)), (0, np.sin(a), np.cos(a))))
    ry = np.array(((np.cos(b), 0, np.sin(b)), (0, 1, 0), (-np.sin(b), 0, np.cos(b))))
    rz = np.array(((np.cos(c), -np.sin(c), 0), (np.sin(c), np.cos(c), 0), (0, 0, 1)))
    return rz @ ry @ rx
