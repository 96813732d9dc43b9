"""Do leaf appearances cover and shine as what they hide does, of kinds that nothing was fitted to?

    python -m tests.tools.leaf_appearances [KIND...] [-o results/appearance/judged.json]

Objects stand alone on level ground, in the light of sun and sky. Of each, displayed down to level 2
and to every finer level that hides something, the cover is compared with that of the whole object
from 64 directions, and its radiance, path traced on grass, from 16 azimuths at two elevations under
three suns; the eye is so far off that its rays are nearly parallel. Judged are the kinds of tree in
``tree_kinds`` beside this file, imported models of the tests, frozen, and the project's own species
of two seeds that no preset uses and of the presets' own. Nothing here changes what is fitted.
"""

import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path

import click
import numpy as np
from tqdm import tqdm

from bench.counting import FLAT
from bench.records.provenance import provenance, scene_digest
from lod.air import CLEAR
from lod.arrays import Reals
from lod.camera import Camera, Corner, camera_from_heading
from lod.metric import METRICS
from lod.pruner import BlendWeights, Cut, Parts, cut_from_parts, prune
from lod.shapes import Appearance, Sticks, StickTable, Triangles, batches_of
from lod.view import View
from scenes.appearance.tone import Illumination
from scenes.appearance.visible_area import visible_areas
from scenes.field.species_field import Placed
from scenes.files import write_text
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, Light, Quality
from scenes.ground.shading import GROUND_MATERIALS
from scenes.model_files import tree_species_names
from scenes.models.catalogue import MODELS, PROTOTYPE_SEED, at_rest
from scenes.render.render import render_frame
from scenes.render.variants import choose
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.areas import directions
from scenes.sticks.prototype import LUMINANCE, Prototype, Shapes
from scenes.trees.species import CALM_SUMMER, TreeSpecies, read_species, tree_species
from scenes.trees.tree import tree_prototypes

UNSEEN = ("poplar", "acacia", "pine")
"""Kinds of tree whose parameters were frozen before the fit that they judge."""

UNSEEN_SEEDS = (71, 72)
"""Seeds that no preset uses."""

IMPORTED = {"mill": "mill.usda", "lamp_tree": "lamp_tree.glb"}
"""Imported models of five levels, by the names of their files."""

OTHERS = ("figure", "boulder")
"""Models that are no trees."""

KINDS = Path(__file__).parent / "tree_kinds"


@dataclass(frozen=True)
class Case:
    """One object: the name of its kind, and the seed that it grew from."""

    kind: str
    seed: int

    @property
    def title(self) -> str:
        """Name the object in tables."""
        return self.kind if self.kind in IMPORTED else f"{self.kind}, seed {self.seed}"


def cases() -> list[Case]:
    """Return what is judged: unseen kinds, imported models, unseen seeds, and what presets have."""
    own = tree_species_names()
    found = [Case(kind, UNSEEN_SEEDS[0]) for kind in UNSEEN]
    found += [Case(kind, PROTOTYPE_SEED) for kind in IMPORTED]
    found += [Case(kind, seed) for seed in UNSEEN_SEEDS for kind in own]
    return found + [Case(kind, PROTOTYPE_SEED) for kind in (*own, *OTHERS)]


def species_of(kind: str) -> TreeSpecies:
    """Return the species of a kind of this study, or of the project's own of that name."""
    return read_species(KINDS / f"{kind}.toml") if kind in UNSEEN else tree_species(kind)


def prototype_of(case: Case) -> Prototype | RiggedPrototype:
    """Make the object of a case, in summer and at rest."""
    if case.kind in IMPORTED:
        from scenes.imported.imported_prototype import imported_prototype
        from scenes.imported.library import read_model

        return imported_prototype(case.kind, read_model(KINDS / IMPORTED[case.kind]))
    if case.kind in OTHERS:
        (made,) = MODELS[case.kind](case.seed, 1, CALM_SUMMER)
        return at_rest(made) if isinstance(made, RiggedPrototype) else made
    return tree_prototypes(case.seed, 1, species_of(case.kind))[0]


@dataclass(frozen=True, eq=False)
class LoneObject:
    """An object alone on level ground, with all of its parts.

    placed  the object; every: the cut that displays all of it
    """

    placed: Placed
    every: Cut

    @property
    def finest(self) -> int:
        """Return the finest level of detail."""
        return int(self.every.level.max())

    @property
    def reach(self) -> float:
        """Return the radius about its foot that holds all of it [m]."""
        return float(self.placed.prototypes.part_tables.bound[0])

    def shown(
        self,
        level: int,
        sin_elevation: float,
        cos_azimuth: float = math.nan,
        light: Illumination | None = None,
    ) -> Appearance:
        """Return what is displayed while parts down to a level are, seen from one direction.

        cos_azimuth  of the angle between the lines to the eye and to the sun on the map
        light        that it is displayed in; None: shapes have their own albedo
        """
        parts = self.every.parts
        n, owns = len(parts), np.zeros(len(parts), np.bool_)
        owns[parts.parent[parts.parent >= 0]] = True
        inner = (parts.level < level) & owns
        leaf = (parts.level == level) | ((parts.level < level) & ~owns)
        weights = BlendWeights(
            inner.astype(np.float64),
            leaf.astype(np.float64),
            np.full(n, sin_elevation),
            np.full(n, cos_azimuth),
        )
        return self.placed.prototypes.appearance(parts, weights, light)


def lone_object(case: Case) -> LoneObject:
    """Make the object of a case, and display all of it."""
    placed = Placed(case.kind, prototype_of(case), 0.0, 0.0, 90.0, FLAT)
    away = np.array((0.0, -30.0, 2.0))
    camera = camera_from_heading(Corner(0, 0), away, 0.0, 0.0, 60.0, (64, 64))
    view = View(camera, METRICS["full"], look_around=True)
    return LoneObject(placed, prune(placed, replace(view, fade=0.0)))


def shapes_of(shown: Appearance) -> Shapes:
    """Return what is displayed as sticks of a single part, and triangles."""
    sticks, corners, colours = [], [np.zeros((0, 3, 3))], [np.zeros((0, 3))]
    for each in batches_of(shown):
        if isinstance(each, Sticks):
            columns = each.start, each.end, each.start_radius, each.end_radius, each.tint
            sticks.append(StickTable(np.array((0, len(each))), *columns))
        elif isinstance(each, Triangles):
            corners.append(each.vertices[each.faces])
            colours.append(each.colours[each.faces].mean(axis=1))
    flat = np.concatenate(corners), np.concatenate(colours)
    return Shapes(StickTable.as_one_part(sticks), *flat)


def unit(azimuth_deg: Reals | float, elevation_deg: Reals | float) -> np.ndarray:
    """Compute unit vectors of azimuths from the x axis and of elevations, (…, 3)."""
    a, e = np.radians(azimuth_deg), np.radians(elevation_deg)
    a, e = np.broadcast_arrays(a, e)
    return np.stack((np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)), axis=-1)


SUNS_DEG, EYES_DEG, AZIMUTHS = (10.0, 40.0, 70.0), (0.0, 30.0), 16
"""Elevations of the sun and of the eye, and the number of its azimuths from the sun."""

_SUN_STEPS = 5
"""Steps by which the sun goes on where its angle to the eye goes on by one: pairs lie evenly (a
lattice), with the sun in all azimuths and the eye, which goes on by one step more, in half."""

SIZE_PX, AWAY, GROUND_RADII = 256, 60.0, 6.0
"""Side of a picture; distance of the eye and half the side of the ground, in the object's radii."""


@lru_cache(maxsize=1)
def _whole(one: LoneObject) -> dict[tuple[float, float], float]:
    return _mean_radiance(one, one.finest)


def radiance_ratios(one: LoneObject, level: int) -> Reals:
    """Compute the radiance of a level over that of the whole, for every sun and elevation.

    Both are means over all samples that meet the object from any azimuth.
    """
    whole, found = _whole(one), _mean_radiance(one, level)
    return np.array([found[key] / whole[key] for key in whole])


def _mean_radiance(one: LoneObject, level: int) -> dict[tuple[float, float], float]:
    """Mean luminance of an object down to a level, by elevation of the sun and of the eye."""
    return {
        (sun, eye): float(np.concatenate(list(_samples(one, level, sun, eye))).mean())
        for sun in SUNS_DEG
        for eye in EYES_DEG
    }


def _samples(one: LoneObject, level: int, sun_deg: float, eye_deg: float) -> Iterator[Reals]:
    """Yield the luminance of every sample that meets the object, azimuth by azimuth."""
    quality, tone = Quality(choose(), 1, 0), Illumination(sun_deg)
    for number, (sun_at, turn) in enumerate(azimuths(AZIMUTHS)):
        light = Light((90.0 - sun_at) % 360.0, sun_deg)  # counter-clockwise from the x axis
        seen_from = math.sin(math.radians(eye_deg)), math.cos(math.radians(turn))
        seen = one.shown(level, *seen_from, tone)
        shown = DisplayedRepresentation("object", one.every, seen), _ground(one)
        camera = _camera(one, unit(sun_at + turn, eye_deg))
        layers = render_frame(FrameInput(camera, shown, CLEAR, light, quality), number)
        yield (layers.rgb.astype(np.float64) @ LUMINANCE)[layers.object == 1]


def azimuths(count: int) -> list[tuple[float, float]]:
    """Choose azimuths of the sun, and of the eye from the sun, so many pairs [deg].

    The sun goes round, too, so that no side of the object faces it or the eye more than another.
    """
    step = 360.0 / count
    return [(_SUN_STEPS * k * step % 360.0, (k + 0.5) * step) for k in range(count)]


def _camera(one: LoneObject, toward: Reals) -> Camera:
    """Look at the middle of an object from afar."""
    radius, middle, tall = _cylinder(one)
    half, away = 1.1 * max(radius, tall / 2), AWAY * one.reach
    eye = np.array((0.0, 0.0, middle)) + away * toward
    up = np.array((0.0, 0.0, 1.0)) - toward[2] * toward
    fov = 2 * math.atan(half / away)
    return Camera(Corner(0, 0), eye, -toward, up / np.linalg.norm(up), fov, SIZE_PX, SIZE_PX)


@lru_cache(maxsize=1)
def _cylinder(one: LoneObject) -> tuple[float, float, float]:
    """Radius, middle and height of the upright cylinder that holds all of an object [m]."""
    points, radii = shapes_of(one.shown(one.finest, 0.0)).spheres
    low, high = float((points[:, 2] - radii).min()), float((points[:, 2] + radii).max())
    return float((np.hypot(*points.T[:2]) + radii).max()), (low + high) / 2, high - low


def _ground(one: LoneObject) -> DisplayedRepresentation:
    """Make a square of level grass about an object."""
    s = GROUND_RADII * one.reach
    corners = np.array([(-s, -s, 0.0), (s, -s, 0.0), (s, s, 0.0), (-s, s, 0.0)])
    grass = GROUND_MATERIALS["grassy"]
    colour = (np.array(grass.moist) + np.array(grass.dry)) / 2
    up, faces = np.tile((0.0, 0.0, 1.0), (4, 1)), np.array([[0, 1, 2], [0, 2, 3]])
    shape = Triangles(corners, up, np.tile(colour, (4, 1)), faces, np.zeros(2))
    return DisplayedRepresentation("ground", _one_part(), shape)


def _one_part() -> Cut:
    """Make the cut of something that is one part, and is displayed as it is."""
    zero, row = np.zeros(1), np.zeros(1, np.int64)
    at = np.zeros((1, 3))
    parts = Parts(at, at, zero, zero, zero, row, row, row, row - 1, zero + 1)
    return cut_from_parts(parts, 1, 1)


RAYS = 220
"""Rays across the radius that holds an object."""


def cover_ratios(one: LoneObject, level: int) -> Reals:
    """Compute the cover of a level over that of the whole in 64 directions, half from below."""
    around = directions() * np.where(np.arange(64) % 2, -1.0, 1.0)[:, None]
    found = [_cover(one, level, view) / _cover(one, one.finest, view) for view in around]
    return np.array(found)


def _cover(one: LoneObject, level: int, view: Reals) -> float:
    shown = shapes_of(one.shown(level, float(view[2])))
    return float(visible_areas(shown, view[None], one.reach / RAYS).sum())


MEAN_COVER, EACH_COVER, RADIANCE = 0.05, 0.15, 0.03
"""How far the mean cover, that from each direction, and the radiance may be from the whole's."""

HEADER = "object", "level", "mean cover", "worst direction", "radiance, from … to", "within"


@dataclass(frozen=True)
class Judged:
    """One object displayed down to one level, over the whole of it.

    covers     ratio of the covered area in each of 64 directions
    radiances  ratio of the mean radiance for every sun and elevation of the eye; empty where no
               light was asked for
    """

    kind: str
    seed: int
    level: int
    covers: tuple[float, ...]
    radiances: tuple[float, ...]

    @property
    def mean(self) -> float:
        """Return the mean ratio of covers."""
        return float(np.mean(self.covers))

    @property
    def worst(self) -> float:
        """Return the ratio of covers that is farthest from 1."""
        return max(self.covers, key=lambda ratio: abs(ratio - 1))

    @property
    def within(self) -> bool:
        """Tell whether all that was measured is within the limits."""
        covers = abs(self.mean - 1) <= MEAN_COVER and abs(self.worst - 1) <= EACH_COVER
        return covers and all(abs(ratio - 1) <= RADIANCE for ratio in self.radiances)

    @property
    def cells(self) -> tuple[str, ...]:
        """Return the line of the table."""
        shines = self.radiances and f"{min(self.radiances):.3f} … {max(self.radiances):.3f}"
        names = Case(self.kind, self.seed).title, str(self.level)
        covers = f"{self.mean:.3f}", f"{self.worst:.3f}"
        return *names, *covers, shines or "", "yes" if self.within else "no"


def read_findings(path: Path) -> list[Judged]:
    """Read what a file holds."""
    return [
        Judged(**each) for each in json.loads(path.read_text(encoding="utf-8"))["figures"]["judged"]
    ]


def markdown(found: Iterable[Judged]) -> str:
    """Write findings as a table in Markdown."""
    rule = "|---" * len(HEADER) + "|"
    lines = ["| " + " | ".join(HEADER) + " |", rule]
    lines += ["| " + " | ".join(each.cells) + " |" for each in found]
    return "\n".join(lines) + "\n"


COARSEST = 2
"""The coarsest level that is judged."""

_DIGITS = 4


def judged(case: Case, coarsest: int) -> Iterator[Judged]:
    """Measure the levels of one object."""
    one = lone_object(case)
    for level in range(min(coarsest, one.finest - 1), one.finest):
        covers = cover_ratios(one, level).round(_DIGITS).tolist()
        radiances = radiance_ratios(one, level).round(_DIGITS).tolist()
        yield Judged(case.kind, case.seed, level, tuple(covers), tuple(radiances))


@click.command()
@click.argument("kinds", nargs=-1)
@click.option("-o", "path", type=click.Path(path_type=Path), help="A file for what is found.")
def command(kinds: tuple[str, ...], path: Path | None) -> None:
    """Judge objects of these KINDS, by default all, and print the table of docs/appearance.md."""
    chosen = [each for each in cases() if not kinds or each.kind in kinds]
    found: list[Judged] = []
    for case in tqdm(chosen, unit="object"):
        found += judged(case, COARSEST)
    click.echo(markdown(found))
    if path:
        figures = {"judged": [asdict(each) for each in found]}
        made_by = asdict(provenance(scene_digest({}), 0, variant=choose()))
        record = {"study": "leaf appearances", "settings": {}, "figures": figures}
        text = json.dumps(record | {"provenance": made_by}, indent=1, allow_nan=False)
        write_text(path, text + "\n")


if __name__ == "__main__":
    command()
