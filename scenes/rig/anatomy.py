"""Which tables describe a kind of object: its joints, parts, sticks, rest pose and joint limits.

Each side is given once: a ``side_`` entry describes the left side, and its mirror image in the
plane y = 0 is the right side. x is forward, y to the left, z up.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

Vector = tuple[float, float, float]
Limits = tuple[Vector, Vector]
Colour = tuple[float, float, float]

SIDES = {"left": 1.0, "right": -1.0}
"""Sign of y on each side."""

MEAN = "mean"
"""Material of a blob: the mean tint of everything that it replaces, by outline area."""


class Rod(NamedTuple):
    """A stick in a joint's frame: two ends, two radii, a material; ``pair``: its mirror too."""

    joint: str
    start: Vector
    end: Vector
    start_radius: float
    end_radius: float
    material: str
    pair: bool = False


class Joint(NamedTuple):
    """A joint of the modelling skeleton (§2.3): where it sits in the frame of its parent.

    rest    angles about x, y, z as the object stands [degrees]
    limits  (low, high) angles; None: the joint does not turn from rest
    """

    parent: str
    offset: Vector
    rest: Vector = (0.0, 0.0, 0.0)
    limits: Limits | None = None


class Part(NamedTuple):
    """A part of the detail hierarchy (figs 1, 2): its whole, its level, the joint at its origin.

    body  sticks of its own
    leaf  its leaf appearance; without one the part looks as it is, and the whole object is one
          upright stick as high as it
    core  sticks that a part without a body hides inside its parts; without them these are its leaf
          appearance, thinned, and for the whole object nothing
    """

    whole: str
    level: int
    joint: str
    body: tuple[Rod, ...] = ()
    leaf: tuple[Rod, ...] = ()
    core: tuple[Rod, ...] = ()


@dataclass(frozen=True)
class Anatomy:
    """Tables of one kind of object. ``side_`` entries are given for the left and mirrored.

    shift   (low, high) how far the whole may bob and sway, in the tables' lengths
    """

    joints: dict[str, Joint]
    side_joints: dict[str, Joint]
    parts: dict[str, Part]
    side_parts: dict[str, Part]
    shift: Limits

    @property
    def part_names(self) -> tuple[str, ...]:
        """Return the names of the parts, in the order of the hierarchy's rows."""
        return tuple(self.both_sides(self.parts, self.side_parts))

    def both_sides(self, trunk: dict[str, Any], side: dict[str, Any]) -> dict[str, Any]:
        """Return the trunk's entries, then those of the left side, then their mirror images."""
        sided = self.side_joints.keys() | self.side_parts.keys()
        named = dict(trunk)
        for hand in SIDES:

            def here(reference: str, hand: str = hand) -> str:
                return f"{hand} {reference}" if reference in sided else reference

            for name, entry in side.items():
                named[f"{hand} {name}"] = _with_references(entry, here)
        return named


@dataclass(frozen=True)
class Build:
    """How one object differs from the tables of its kind.

    height     of its highest point as it stands [m]
    materials  linear Rec.709 albedo of every material that the tables name
    girth      factor on every radius
    stretch    factors on how far out to the side a joint sits
    sizes      factors on all lengths in the frame of a joint: a child's head is larger
    """

    height: float
    materials: dict[str, Colour]
    girth: float = 1.0
    stretch: dict[str, float] = field(default_factory=dict)
    sizes: dict[str, float] = field(default_factory=dict)


def side_of(name: str) -> tuple[float, str]:
    """Return the sign of a name's side (+1 on the left and in the middle), and the bare name."""
    hand, _, bare = name.partition(" ")
    return (SIDES[hand], bare) if hand in SIDES else (1.0, name)


def _with_references(entry, here):  # type: ignore[no-untyped-def]
    """Pass every name of a joint or part in an entry through ``here``."""
    if isinstance(entry, Joint):
        return entry._replace(parent=here(entry.parent))
    rods = (
        tuple(rod._replace(joint=here(rod.joint)) for rod in table)
        for table in (entry.body, entry.leaf, entry.core)
    )
    return Part(here(entry.whole), entry.level, here(entry.joint), *rods)
