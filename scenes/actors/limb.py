"""The limbs of a live actor: what each joint of a rig carries, moved by messages (§3.1.1).

The modelling tree is an actor each joint (§2.3). A limb is called as what its joint carries,
without a side that it shares with the limb that carries it: a person's right hand is
``torso/abdomen/chest/right arm/forearm/hand``. A body lets the limbs on the way be left out
(``scenes.actors.body``): ``right arm/hand``.

Limbs follow a walk. Its stride goes as speed to the power 0.6, as among the walkers of a field
(``scenes.field.species_field``). Below ``SLOWEST`` of its own speed a walker's strides keep their
length and its pose goes over to that at rest, in steps of an eighth; from there on it stands.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from lod.actors.actor import Components, CompoundActor, JointLimits, RevoluteJoint, Vector
from lod.actors.object_with_parts import SEPARATOR, Route, ask, change, mutator, query
from scenes.figures.anatomy import SIDES
from scenes.models.catalogue import at_rest
from scenes.rig.rig import Motion, Quaternions, rotate_vectors
from scenes.rig.rigged_prototype import RiggedPrototype

Pose = Sequence[tuple[Vector, Components]]
"""Position in the frame of its whole [m] and orientation of every joint of a rig, row by row."""


class LimbTree(NamedTuple):
    """Row of a joint in its rig (−1 is the body itself), and the trees of the limbs it carries."""

    row: int
    limbs: "tuple[tuple[str, LimbTree], ...]"


class Limb(CompoundActor):
    """A joint with all that it carries. It follows the body's motion until a message turns it."""

    _held = False

    def _set_joint(self, joint: RevoluteJoint) -> None:
        super()._set_joint(joint)
        self._held = True

    @mutator
    def release(self) -> None:
        """Follow the body's motion again, with every limb from here down."""
        self._held = False
        for name in self.part_names():
            self._ask_part(change((name,), "release"))

    @mutator
    def follow(self, tree: LimbTree, pose: Pose, along: Route | None = None) -> None:
        """Take the pose of the body's motion, from here down, where no message holds a limb.

        along  the route on which limbs below do so; None = all of them
        """
        if tree.row >= 0 and not self._held:
            position, turn = pose[tree.row]
            self._joint = RevoluteJoint(position, turn, self._joint.limits)
        self._follow_below(tree, pose, along)

    def _follow_below(self, tree: LimbTree, pose: Pose, along: Route | None) -> None:
        for name, below in tree.limbs:
            if along is None:
                self._ask_part(change((name,), "follow", below, pose))
            elif along[:1] == (name,):
                self._ask_part(change((name,), "follow", below, pose, along[1:]))

    @query
    def held(self, below: bool = True) -> tuple[tuple[Route, Components], ...]:
        """Return the orientations of the limbs that messages hold, with routes from here.

        below  whether those that it carries are asked, too
        """
        found = [((), self._joint.turn)] if self._held else []
        for name in self.part_names() if below else ():
            carried = self._ask_part(ask((name,), "held"))
            found += [((name, *route), turn) for route, turn in carried]
        return tuple(found)


def limb_tree(prototype: RiggedPrototype) -> LimbTree:
    """Arrange the limbs of a prototype as its joints carry one another."""
    parent = prototype.rig.parent.tolist()

    def tree(row: int) -> LimbTree:
        rows = [j for j, above in enumerate(parent) if above == row]
        return LimbTree(row, tuple((_name(prototype, j), tree(j)) for j in rows))

    return tree(-1)


def limb_routes(tree: LimbTree, so_far: Route = ()) -> dict[Route, int]:
    """List the route from the body to each limb, with the row of its joint."""
    found: dict[Route, int] = {}
    for name, below in tree.limbs:
        found[*so_far, name] = below.row
        found |= limb_routes(below, (*so_far, name))
    return found


def build_limbs(prototype: RiggedPrototype, tree: LimbTree) -> dict[str, Limb]:
    """Build the limbs of a body at rest, by name."""
    rig = prototype.rig

    def built(below: LimbTree) -> Limb:
        j = below.row
        limits = JointLimits(rig.low[j].tolist(), rig.high[j].tolist())
        here = RevoluteJoint(rig.offset[j].tolist(), rig.rest[j].tolist(), limits)
        return Limb({name: built(each) for name, each in below.limbs}, here)

    return {name: built(below) for name, below in tree.limbs}


def _name(prototype: RiggedPrototype, row: int) -> str:
    """Name a limb, without the side or the path that it shares with the limb that carries it.

    Limbs of imported models have the paths of their nodes: ``mill/rotor`` of a mill is ``rotor``.
    """
    parent = int(prototype.rig.parent[row])
    if "/" in prototype.limbs[row]:
        root = prototype.limbs[row].partition("/")[0]
        path = prototype.limbs[parent] if parent >= 0 else root
        below = prototype.limbs[row].removeprefix(f"{path}/")
        return below.replace(SEPARATOR, " ").replace(".", " ")
    side, _, bare = prototype.limbs[row].partition(" ")
    above = prototype.limbs[parent].partition(" ")[0] if parent >= 0 else ""
    return bare if side in SIDES and side == above else prototype.limbs[row]


EIGHTHS = 8  # steps in which a pose goes from rest (0) to the whole walk

SLOWEST, STRIDE_POWER, LONGEST_STRIDE = 0.1, 0.6, 1.3
"""Speed below which a walker's pose goes over to rest, power of the speed as which the stride goes,
and the longest stride; faster bodies take more strides. As shares of the prototype's own."""


class Step(NamedTuple):
    """How a body steps: eighths of its walk, stride as a share, cycles of its motion a second."""

    eighths: int
    stride_factor: float
    cadence: float


def step_at(motion: Motion, speed: float) -> Step:
    """Find how a body with that motion steps at a speed [m/s]."""
    if motion.stride == 0:
        return Step(EIGHTHS, 1.0, 1.0 / motion.period)
    relative = speed / motion.speed
    if relative < 1e-3:
        return Step(0, 1.0, 0.0)
    eighths = min(EIGHTHS, math.ceil(EIGHTHS * relative / SLOWEST))
    factor = min(max(relative, SLOWEST) ** STRIDE_POWER, LONGEST_STRIDE)
    return Step(eighths, factor, speed / (factor * motion.stride * eighths / EIGHTHS))


def planted_phase(motion: Motion, phase: float, before: Step, after: Step) -> float:
    """Return the phase at which feet that stand keep their prints as the stride changes [cycles].

    Prints scale with the stride, those ahead and those behind; so the phase goes on or back by as
    much as leaves the mean of those that stand where it is. Who stood sets off in mid-stance, in
    which a print lies beside the body, as at rest.
    """
    if after.eighths == 0 or not _stands(motion):
        return phase
    if before.eighths == 0:
        return min(_mid_stances(motion), key=lambda each: abs((each - phase + 0.5) % 1.0 - 0.5))
    kept = before.stride_factor * before.eighths / (after.stride_factor * after.eighths)
    middle = prints_ahead(motion, phase)
    return (phase + middle - min(max(middle * kept, -0.5), 0.5)) % 1.0


def prints_ahead(motion: Motion, phase: float) -> float:
    """Compute how far ahead of mid-stance the prints of those feet lie that stand [strides].

    It is the mean of them, and 0 where none stands.
    """
    own = [((phase - strike) % 1.0, duty) for strike, duty in _stands(motion)]
    ahead = [duty / 2 - at for at, duty in own if at <= duty]
    return sum(ahead) / len(ahead) if ahead else 0.0


@lru_cache(maxsize=256)
def _stands(motion: Motion) -> tuple[tuple[float, float], ...]:
    """List the phase at which each leg lands, and the share of the cycle that it stands."""
    return tuple(zip(motion.feet.strike.tolist(), motion.feet.duty.tolist(), strict=True))


@lru_cache(maxsize=256)
def _mid_stances(motion: Motion) -> tuple[float, ...]:
    """Find the phases of mid-stance of a leg at which all that stand are nearest to theirs."""
    off = {}
    for first, share in _stands(motion):
        phase = (first + share / 2) % 1.0
        own = [((phase - strike) % 1.0, duty) for strike, duty in _stands(motion)]
        off[phase] = max(abs(at - duty / 2) for at, duty in own if at <= duty)
    return tuple(phase for phase, most in off.items() if most < min(off.values()) + 1e-9)


@lru_cache(maxsize=512)
def with_share(prototype: RiggedPrototype, eighths: int) -> RiggedPrototype:
    """Return the prototype with so many eighths of its motion, the rest of it as it stands."""
    motion, share = prototype.motion, eighths / EIGHTHS
    if eighths == EIGHTHS or motion.stride == 0:
        return prototype
    if eighths == 0:
        return at_rest(prototype)
    rest = np.broadcast_to(prototype.rig.rest, motion.rotations.shape)
    turned = slerp(rest, motion.rotations, share)
    shift, stride = motion.shift * share, motion.stride * share
    less = replace(motion, rotations=turned, shift=shift, stride=stride)
    # Limbs half way between two poses are not half as high: feet stay on the ground, none below it.
    down = share * _lowest(prototype, motion) - _lowest(prototype, less)
    raised = shift + down[:, None] * (0.0, 0.0, 1.0)
    return replace(prototype, motion=replace(less, shift=raised))


def _lowest(prototype: RiggedPrototype, motion: Motion) -> np.ndarray:
    ends, radii = stick_ends(prototype, motion)
    return (ends[..., 2] - radii).min(axis=1, initial=np.inf)


def slerp(a: Quaternions, b: Quaternions, share: float) -> np.ndarray:
    """Interpolate between rotations (…, 4), the shorter way round (Shoemake 1985)."""
    cosine = (a * b).sum(axis=-1, keepdims=True)
    b, cosine = b * np.copysign(1.0, cosine), np.abs(cosine)
    sine = np.linalg.norm(b - cosine * a, axis=-1, keepdims=True)
    angle = np.maximum(np.arctan2(sine, cosine), 1e-9)
    return (np.sin((1 - share) * angle) * a + np.sin(share * angle) * b) / np.sin(angle)


def pose_at(prototype: RiggedPrototype, phase: float) -> tuple[np.ndarray, np.ndarray]:
    """Compute rotations (j, 4) and shift (3,) [m] of a prototype's motion at a phase [cycles]."""
    motion = prototype.motion
    keys = len(motion.rotations)
    along = (phase % 1.0) * keys
    k = min(int(along), keys - 1)
    rotations = slerp(motion.rotations[k], motion.rotations[(k + 1) % keys], along - k)
    shift = (1 - along + k) * motion.shift[k] + (along - k) * motion.shift[(k + 1) % keys]
    return rotations, shift


def stick_ends(
    prototype: RiggedPrototype, motion: Motion | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Compute the ends of all sticks at each key, (k, e, 3), and their radii, (e,) [m].

    They are in the object's own frame; what a body wears itself, which does not move against it, is
    left out. ``motion``: in place of the prototype's own.
    """
    motion = motion or prototype.motion
    origin, facing = prototype.rig.frames(motion.rotations, motion.shift)
    ends, radii = [], []
    for table in prototype.full_detail_sticks():
        on, (point, radius), own = table.joints, table.spheres, table.joints >= 0
        ends.append(rotate_vectors(facing[:, on[own]], point[own]) + origin[:, on[own]])
        radii.append(radius[own])
    return np.concatenate(ends, axis=1), np.concatenate(radii)
