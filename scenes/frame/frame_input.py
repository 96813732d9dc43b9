"""What one frame is rendered from: what is displayed, the light, and how it is sampled.

It is passed whole to the renderer, which gives layers: arrays. Nothing here knows of it.
"""

import hashlib
import math
import struct
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TypeGuard

import numpy as np

from lod.air import Air
from lod.camera import Camera
from lod.errors import InputError
from lod.pruner import (
    BlendWeights,
    Cut,
    Moving,
    Parts,
    Representation,
    blend_weights,
    cut_from_parts,
)
from lod.shapes import Appearance, Instanced, Sticks, SticksAndTriangles
from lod.update_schedule import DrawnState, apply_state
from lod.view import View
from scenes.field.cells import CellSamples
from scenes.field.species_field import SpeciesField


@dataclass(frozen=True, eq=False)
class Posing:
    """How the displayed parts of a representation are posed and drawn at other times.

    parts    the displayed parts as they stand at the view's time
    weights  by which inner and leaf appearances are blended, whenever they are drawn
    """

    representation: Representation
    parts: Parts
    weights: BlendWeights
    view: View

    def parts_at(self, time_s: float) -> Parts:
        """Return the displayed parts as they stand at a time; the very same where nothing moves."""
        if time_s == self.view.time_s or not isinstance(self.representation, Moving):
            return self.parts
        return self.representation.later(self.parts, self.view, time_s)

    def shape_at(self, time_s: float) -> Appearance:
        """Return their appearance at a time, in the coordinates of the view's frame."""
        return self.representation.appearance(self.parts_at(time_s), self.weights)

    def moves(self, time_s: float) -> bool:
        """Tell whether any of them stands elsewhere at that time."""
        return self.parts_at(time_s) is not self.parts


@dataclass(frozen=True, eq=False)
class DisplayedRepresentation:
    """What one representation displays at one time, in the coordinates of its frame.

    cut     the displayed parts; ``shape.owner`` gives their rows
    shape   their appearance
    copies  what is drawn whole beside, as copies of models, of which the cut has the wholes alone
    later   the same sticks and meshes a frame later, row by row; None where nothing moves till then
    posing  gives the appearance at other times; None for what never moves
    drawn   which sticks are still drawn as they were in an earlier frame; None: none are
    """

    name: str
    cut: Cut
    shape: Appearance
    copies: Instanced | None = None
    later: Sticks | SticksAndTriangles | None = None
    posing: Posing | None = None
    drawn: DrawnState | None = None

    def moves(self, time_s: float) -> bool:
        """Tell whether any displayed part stands elsewhere at that time."""
        return self.posing is not None and self.posing.moves(time_s)

    def at(self, time_s: float, later_s: float | None = None) -> "DisplayedRepresentation":
        """Return the same parts drawn at a time, with where their sticks are at a later one."""
        if self.posing is None:
            return self
        shape: Appearance = self.shape
        later: Appearance | None = None
        if self.moves(time_s):
            shape = _drawn(self.drawn, self.posing.shape_at(time_s))
        if later_s is not None and self.moves(later_s):
            later = self.posing.shape_at(later_s)
        if not isinstance(later, Sticks | SticksAndTriangles):
            later = None
        return replace(self, shape=shape, later=later)

    def with_drawn(self, drawn: DrawnState) -> "DisplayedRepresentation":
        """Return the same parts, of which some sticks are still drawn as they were."""
        return replace(self, shape=_drawn(drawn, self.shape), drawn=drawn)


def display(representation: Representation, cut: Cut, view: View) -> DisplayedRepresentation:
    """Ask a representation for the appearance of the parts of a cut, at the view's time."""
    posing = Posing(representation, cut.parts, blend_weights(cut, view), view)
    shape = posing.shape_at(view.time_s)
    if len(cut) and cut.part.max() >= 2**32:  # longer than a frame's 32 bits: number them in order
        cut = replace(cut, part=np.unique(cut.part, return_inverse=True)[1])
    return DisplayedRepresentation(representation.name, cut, shape, posing=posing)


def can_be_copied(representation: Representation, view: View) -> TypeGuard[SpeciesField]:
    """Tell whether whole objects of it may be copies: nothing moves, nor is thinned in the view."""
    if not isinstance(representation, SpeciesField) or representation.moves:
        return False
    hierarchies = representation.prototypes.part_tables.hierarchies
    return not (view.metric.finite and any(each.is_thinned for each in hierarchies))


def display_copies(
    field: SpeciesField, view: View, from_size: float = 1.0, chosen: CellSamples | None = None
) -> DisplayedRepresentation:
    """Display a field that stands still, or what is ``chosen`` of it, what is large as copies.

    Large is what subtends ``from_size`` times the detail; in a view that prunes nothing, all is.
    """
    cut, wholes, copies = field.cut_and_copies(view, from_size, chosen)
    shape = field.appearance(cut.parts, blend_weights(cut, view))
    parts = Parts.concatenate((cut.parts, wholes))
    examined = cut.examined_objects + len(wholes), cut.examined_parts + len(wholes)
    made = copies if len(wholes) else None
    return DisplayedRepresentation(field.name, cut_from_parts(parts, *examined), shape, made)


def _drawn(drawn: DrawnState | None, shape: Appearance) -> Appearance:
    return apply_state(drawn, shape) if drawn and isinstance(shape, Sticks) else shape


@dataclass(frozen=True)
class Window:
    """A rectangle of pixels: from (left, top) to before (right, bottom), rows from the top."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def size(self) -> tuple[int, int]:
        """Return its width and height [px]."""
        return self.right - self.left, self.bottom - self.top

    def is_all_of(self, size: tuple[int, int]) -> bool:
        """Tell whether it is a whole picture of that size."""
        return (self.left, self.top) == (0, 0) and self.size == size

    def share(self, pixels: slice, width: int) -> tuple[np.ndarray, slice]:
        """Find what of a run of a picture's pixels lies in the window, row by row.

        ``width`` is the picture's. Gives whether each pixel of the run does, (n,), and which run of
        the window's own pixels those are.
        """
        number = np.arange(pixels.start, pixels.stop)
        row, column = number // width, number % width
        inside = (self.left <= column) & (column < self.right)
        inside &= (self.top <= row) & (row < self.bottom)
        if not inside.any():
            return inside, slice(0, 0)
        at = int(np.argmax(inside))
        own = (row[at] - self.top) * self.size[0] + column[at] - self.left
        return inside, slice(int(own), int(own) + int(np.count_nonzero(inside)))


SampleWatch = Callable[[int], object]
"""Called again and again while a frame is traced, with the number of samples just taken."""


@dataclass(frozen=True)
class Quality:
    """How a frame is sampled.

    variant    a Mitsuba variant that works here (see variants.choose)
    spp        samples per pixel, taken exactly
    max_depth  longest light path, in edges: 2 is direct light only
    haze       how the air between is worked out: in closed form whose airlight is the horizon's sky
        (analytic), or as a medium that scatters light (medium, the reference)
    sun_sampling  share of light samples for the sun against 1 for the sky, in scalar and spectral
        variants and in a medium; elsewhere the sun is sampled at every vertex
    coverage   whether it is counted which objects the samples of a pixel meet
    window     what of the picture is rendered; None = all of it
    most_samples  traced at once: bounds memory, and how long Ctrl-C waits
    """

    variant: str
    spp: int = 16
    seed: int = 0
    max_depth: int = 4
    haze: str = "analytic"
    sun_sampling: float = 12.0
    coverage: bool = False
    window: Window | None = None
    most_samples: int = 2**19

    def __post_init__(self) -> None:
        if self.is_spectral and self.haze != "analytic":
            rule = "analytic where pictures are spectral"
            raise InputError("--haze", self.haze, rule, "leave out --spectral")

    def window_of(self, size: tuple[int, int]) -> Window:
        """Return the window that is rendered of a picture of that size [px]."""
        return self.window or Window(0, 0, *size)

    @property
    def is_jit(self) -> bool:
        """Tell whether the variant traces wavefronts of rays with code that it compiles."""
        return not self.variant.startswith("scalar_")

    @property
    def draws_copies(self) -> bool:
        """Tell whether copies of a model share its shapes in the renderer (``lod.shapes``)."""
        return self.is_jit and not self.is_spectral and self.haze == "analytic"

    @property
    def is_spectral(self) -> bool:
        """Tell whether light has wavelengths, and not just three colours."""
        return self.variant.endswith("_spectral")


def sampler_seed(seed: int, frame: int, *where: int) -> int:
    """32 bits for Mitsuba's samplers: BLAKE2b of seed, frame and place as 8-byte integers."""
    words = struct.pack(f"<Q{1 + len(where)}q", seed, frame, *where)
    digest = hashlib.blake2b(words, digest_size=4, person=b"lodbench frame").digest()
    return int.from_bytes(digest, "little")


@dataclass(frozen=True)
class Light:
    """Sun and sky that light a world.

    sun_azimuth_deg    clockwise from north (+y) [degrees]
    sun_elevation_deg  above the horizon [degrees]
    """

    sun_azimuth_deg: float
    sun_elevation_deg: float
    turbidity: float = 3.0

    @property
    def to_sun(self) -> np.ndarray:
        """Return the unit vector to the sun, (3,)."""
        a, e = math.radians(self.sun_azimuth_deg), math.radians(self.sun_elevation_deg)
        return np.array((math.sin(a) * math.cos(e), math.cos(a) * math.cos(e), math.sin(e)))


@dataclass(frozen=True, eq=False)
class FrameInput:
    """All that one frame is rendered from.

    displayed  what each representation displays, in the coordinates of the camera's corner
    after      the next frame's camera, where motion vectors are asked for
    denoise    whether a denoised picture is asked for
    subframes  inputs of the sub-frames while the shutter is open, made when called; none where
               nothing moves, or the shutter is open for no time
    seconds    of the stages that made this input, such as pruning
    counts     worth keeping beside those of the scene
    """

    camera: Camera
    displayed: tuple[DisplayedRepresentation, ...]
    air: Air
    light: Light
    quality: Quality
    after: Camera | None = None
    denoise: bool = False
    subframes: tuple[Callable[[], "FrameInput"], ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
