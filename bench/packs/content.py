"""What is in a pack? A still world of a given size, all of it, as plain arrays.

A pack's world is a preset whose objects stand still, in a square window whose southern end (as the
camera looks) the camera stands near. The ground is one mesh, cut for the still's camera; every
object is a copy of a model. The reference is rendered from the very arrays that are written.
"""

import hashlib
import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from lod.arrays import Ints
from lod.camera import Camera
from lod.errors import InputError
from lod.metric import METRICS
from lod.pruner import BlendWeights, Parts, cross_fade, prune
from lod.shapes import Appearance, Instanced, batches_of
from lod.view import View
from scenes.field.species_field import SpeciesField
from scenes.frame.frame_input import FrameInput, display, display_copies
from scenes.presets.load import load_preset
from scenes.render.description import Copies, Description, describe_frame
from scenes.render.variants import choose
from scenes.scene import Scene, frame_quality

SIZES = {"small": 1e3, "medium": 1e4, "large": 1e5}
"""Objects of a pack by the size in its name; as many on average as grow there."""

WALK_FRAMES, WALK_SIZE = 24, (320, 180)  # frames of the walk, and their width and height [px]

_AHEAD = 0.4  # how far behind the middle of the window the camera stands, as a share of its side


@dataclass(frozen=True)
class World:
    """One world of packs.

    preset  it is made of, and ``settings`` that differ
    grown   share of the objects that a habitat lets grow
    aside_m  how far to the right the camera stands, so that nobody stands before it
    reach_m, detail_px  how far its ground reaches, and how finely it is cut
    """

    preset: str
    settings: tuple[str, ...]
    reach_m: float
    detail_px: float = 2.0
    grown: float = 1.0
    aside_m: float = 0.0


WORLDS = {
    "crowd": World("crowd", ("species.figure.sizes=[1.0]", "species.tree.sizes=[1.0]"), 2000.0),
    "meadow": World(
        "meadow",
        (
            *("species.figure.density=0.02", "species.tree.density=0.004"),
            *("species.sward.density=2.0", "species.tree.sizes=[1.0]", "species.sward.sizes=[1.0]"),
        ),
        2000.0,
        aside_m=3.0,
    ),
    "forest": World(
        "forest",
        (
            *(f"species.{name}.prototypes=2" for name in ("broadleaf", "birch", "conifer")),
            *(f"species.{name}.sizes=[1.0]" for name in ("broadleaf", "birch", "conifer")),
            *("species.dead_tree.sizes=[1.0]", "species.shrub.sizes=[0.8]"),
            *("species.shrub.prototypes=2", "species.sward.density=0"),
        ),
        600.0,
    ),
    "mountain": World(
        "mountain",
        (
            *("camera.cell=[0,0]", "camera.height=3.0", "species.conifer.prototypes=2"),
            *("species.conifer.sizes=[0.9]", "species.boulder.sizes=[0.8]"),
            "species.boulder.prototypes=2",
        ),
        16384.0,
        4.0,
        0.32,
    ),
}
"""The worlds by the first word of a pack's name."""


def settings_of(name: str) -> tuple[str, tuple[str, ...]]:
    """Return the preset of a pack and its settings. Raises InputError for no name of one."""
    word, _, size = name.partition("-")
    if word not in WORLDS or size not in SIZES:
        rule = f"WORLD-SIZE, of {', '.join(WORLDS)} and {', '.join(SIZES)}"
        raise InputError("NAME", name, rule, "try crowd-small")
    world = WORLDS[word]
    plain = load_preset(world.preset, world.settings)
    density = world.grown * sum(each.density for each in plain.species.values())
    side = round(math.sqrt(SIZES[size] / density), 3)
    heading = math.radians(plain.camera.heading)
    ahead = np.array([math.sin(heading), math.cos(heading)])
    place = -_AHEAD * side * ahead + world.aside_m * ahead[::-1] * (1, -1)
    x, y = place.round(3).tolist()
    still = (f"species.{k}.patrol=0" for k, each in plain.species.items() if each.patrol)
    return world.preset, (
        *world.settings,
        *still,
        f"world.extent={side!r}",
        *(f"camera.position=[{x!r}, {y!r}]", "camera.speed=1.4", "camera.fps=24"),
        *("terrain.finest=1.0", f"terrain.reach={max(world.reach_m, side)!r}"),
        f"view.detail={world.detail_px!r}",
    )


@dataclass(frozen=True, eq=False)
class Content:
    """A pack's world: everything that its files are written from.

    scene, view  of the still
    made         the still's input: the ground, and every object as a copy of a model
    """

    scene: Scene
    view: View
    made: FrameInput

    @cached_property
    def description(self) -> Description:
        """Describe the still's frame as plain arrays."""
        return describe_frame(self.made)

    @property
    def ground(self) -> Description:
        """Return the mesh of the ground."""
        (mesh,) = self.description["shapes"].values()
        found: Description = mesh
        return found

    @property
    def copies(self) -> Copies:
        """Return the models' shapes, and where their copies stand."""
        found: Copies = self.description["copies"]
        return found

    @cached_property
    def distinct(self) -> tuple[list[int], Ints]:
        """Return the models that stand somewhere and differ in their shapes, and which of these
        each copy is, (n,)."""
        keys = [_shapes_key(each) for each in self.copies.models]
        used = np.unique(self.copies.which).tolist()
        firsts = {keys[k]: k for k in reversed(used)}
        kept = sorted(firsts.values())
        row = np.array([kept.index(firsts[key]) if key in firsts else -1 for key in keys])
        return kept, row[self.copies.which]

    @cached_property
    def levels(self) -> list[list[list[Description]]]:
        """Make of every model the shapes of its coarser levels, the finest of them first."""
        view = whole_view(self.view)
        return [each for field in self.scene.world.fields for each in _levels(field, view)]

    def camera(self, frame: int) -> Camera:
        """Return the camera of a frame of the walk, in the still's coordinates."""
        camera = self.scene.camera(frame, self.made.camera.corner)
        return replace(camera, width=WALK_SIZE[0], height=WALK_SIZE[1])

    def counts(self) -> dict[str, int]:
        """Count what is there, unpruned: copies, parts, sticks and triangles of all copies."""
        of_model = np.zeros((len(self.copies.models), 2), np.int64)
        for row, shapes in enumerate(self.copies.models):
            for shape, owners in shapes:
                of_model[row, int(shape["type"] == "mesh")] += len(owners)
        fields = self.scene.world.fields
        parts = [len(t) for f in fields for t in f.prototypes.part_tables.hierarchies]
        which = self.copies.which
        sticks, triangles = of_model[which].sum(axis=0).tolist()
        return {
            "instances": len(which),
            "prototypes": len(self.distinct[0]),
            "parts": int(np.array(parts)[which].sum()),
            "sticks": sticks,
            "triangles": triangles + len(self.ground["faces"]),
        }

    def bounds(self) -> list[list[float]]:
        """Return the lowest and the highest corner of all [m], from the boxes of the models."""
        low, high = box_of([self.ground])
        cos, sin = self.copies.turn.T
        for model in np.unique(self.copies.which).tolist():
            box = np.array(box_of([shape for shape, _ in self.copies.models[model]]))
            rows = self.copies.which == model
            x, y = (each.ravel() for each in np.meshgrid(box[:, 0], box[:, 1]))
            c, s = cos[rows, None], sin[rows, None]
            place = self.copies.place[rows]
            east, north = c * x - s * y + place[:, :1], s * x + c * y + place[:, 1:2]
            up = place[:, 2:] + box[:, 2]
            columns = [(each.min(), each.max()) for each in (east, north, up)]
            low, high = (
                pick(e, np.array(c))
                for pick, e, c in zip(
                    (np.minimum, np.maximum), (low, high), zip(*columns, strict=True), strict=True
                )
            )
        return [low.tolist(), high.tolist()]


def box_of(shapes: list[Description]) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest corner of shapes, (3,) each; sticks by their widest."""
    boxes = []
    for shape in shapes:
        points, margin = shape.get("vertices"), 0.0
        if points is None:
            points, margin = shape["control_points"][:, :3], shape["control_points"][:, 3].max()
        boxes.append((points.min(axis=0) - margin, points.max(axis=0) + margin))
    low, high = zip(*boxes, strict=True)
    return np.min(low, axis=0).astype(np.float64), np.max(high, axis=0).astype(np.float64)


def _shapes_key(shapes: list[tuple[Description, np.ndarray]]) -> str:
    digest = hashlib.sha256()
    for shape, _ in shapes:
        for name, column in sorted(shape.items()):
            digest.update(
                name.encode() + np.ascontiguousarray(column).tobytes()
                if isinstance(column, np.ndarray)
                else str(column).encode()
            )
    return digest.hexdigest()


def load_content(preset: str, settings: tuple[str, ...], size: tuple[int, int]) -> Content:
    """Make the world of a pack. Raises InputError where something in it moves."""
    scene = Scene(load_preset(preset, (*settings, f"render.size={size[0]}x{size[1]}")))
    view, bare = scene.view(1), replace(scene.world.terrain, aggregate_cover=None)
    ground = display(bare, prune(bare, view), view)
    quality = frame_quality(scene.preset, choose(scene.preset.render.variant))
    displayed = (ground, *(display_copies(f, whole_view(view)) for f in scene.world.fields))
    made = FrameInput(view.camera, displayed, scene.air, scene.light, quality)
    return Content(scene, view, made)


def whole_view(view: View) -> View:
    """Return the view in which everything is displayed."""
    return replace(view, metric=METRICS["full"], conditions=None, fade=0.0)


class Looks(NamedTuple):
    """Every part of all prototypes of a field, in the order of its tables, and how each looks.

    inner, leaf  appearances in the frame of the part's model; owners are rows of ``parts``
    """

    parts: Parts
    inner: Appearance
    leaf: Appearance


def looks_of(field: SpeciesField, view: View) -> Looks:
    """Return every part of a field's prototypes, with both of its appearances."""
    parts = _all_parts(field, view)
    shares = np.ones(len(parts)), np.zeros(len(parts))
    weights = BlendWeights(*shares), BlendWeights(*reversed(shares))
    return Looks(parts, *(field.appearance(parts, each) for each in weights))


def _all_parts(field: SpeciesField, view: View) -> Parts:
    prototypes = field.prototypes
    tables = prototypes.part_tables
    sizes = [len(each) for each in tables.hierarchies]
    first = np.repeat(tables.root, sizes)
    parent = np.concatenate([each.parent for each in tables.hierarchies])
    parent = np.where(parent < 0, -1, parent + first)
    rows = np.repeat(np.arange(len(sizes)), sizes)
    return prototypes.parts(prototypes.standing, rows, np.arange(len(rows)), parent, view)


def _levels(field: SpeciesField, view: View) -> list[list[list[Description]]]:
    """Make of each prototype the shapes of its coarser levels, from the last but one to a blob."""
    parts = _all_parts(field, view)
    deepest = np.zeros(len(field.species.prototypes), np.int64)
    np.maximum.at(deepest, parts.object, parts.level)
    found: list[list[list[Description]]] = [[] for _ in deepest]
    for level in range(int(deepest.max()) - 1, -1, -1):
        kept = parts.level <= level
        some, row = parts.take(kept), np.cumsum(kept) - 1
        parent = np.where(some.parent < 0, -1, row[some.parent])
        inner, leaf, hidden = cross_fade(parent, some.share, np.ones(len(some)))
        weights = BlendWeights(inner, leaf, hidden_area=hidden)
        shape, none = field.appearance(some, weights), np.zeros((0, 3))
        own = some.object, some.part, some.level
        copies = Copies()
        instanced = Instanced(shape, *own, none[:, 0], none[:, 0], none, none[:, :2])
        copies.add(instanced, batches_of(shape), 0, none[:, 0])
        for model in np.flatnonzero(deepest > level).tolist():
            found[model].append([each for each, _ in copies.models[model]])
    return found
