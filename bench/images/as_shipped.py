"""Presets as shipped against a reference, place by place: what the bar of docs/method.md judges.

A case is one place under one sun. Its reference is traced twice, the second time with other
samples, which gives the floor of errors; the preset with its objects redrawn on the same ground,
at its own detail, gives the ceiling. Under one sun of each place the reference at twice its detail
says how far the last halving moved it. Fields, and the dust of those who walk there, are redrawn;
what is placed one by one stays.
"""

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, pairwise

import numpy as np
from scipy.ndimage import gaussian_filter

from bench.experiment import Case
from bench.images.differences import (
    REFERENCE,
    TESTED,
    Looks,
    Radiance,
    Seen,
    flips,
    look,
    sums_by_band,
)
from bench.records.records import Column, Point, columns
from bench.seeds import BUILDING_SEEDS, QUICK_SEED
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import SKY_Z
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.budget import reference_preset
from scenes.render.variants import choose
from scenes.scene import Scene, World
from scenes.sticks.prototype import LUMINANCE

FIXED_BY = "3eef32fffc4e7785e51f9c06beef6f15d127a368"
"""The commit that fixed the bar, from whose hash the seeds of places are."""

SUNS_DEG = (10.0, 40.0, 70.0)  # elevations of the sun [degrees]

CONVERGENCE = ("in turn", "40°")  # the suns under which references are seen half as fine, too

EVERY_SUN = ("meadow", "forest", "mountain", "aerial")
"""Presets that are seen under all suns at each place."""

BANDS = 8  # the number of bands of distance
OCTAVES_PX = (2, 4, 8, 16)  # where octaves of contrast begin [px]; each ends at twice that

_ROUND_THE_FIRE = "campfire"
_FLIGHT, _LAST_FRAME = "fly_in", 48


@dataclass(frozen=True)
class Place:
    """A preset from one place under one sun: settings laid over it, and the frame's number.

    ``sun`` names what its points are merged by: an elevation, or ``in turn``.
    """

    preset: str
    number: int
    sun: str
    settings: tuple[str, ...]
    frame: int = 1

    @property
    def label(self) -> str:
        """The preset, the number of the place and the sun."""
        return f"{self.preset}, place {self.number}, sun {self.sun}"

    def load(self) -> Preset:
        """Load the preset as it is seen here."""
        return load_preset(self.preset, self.settings)


def places(preset: str, count: int, unseen: bool, size: str | None = None) -> list[Place]:
    """Return ``count`` places of a preset, under each of their suns, in pictures of a size (WxH).

    Without a size it is the preset's own.
    """
    suns = [f"{each:g}°" for each in SUNS_DEG] if preset in EVERY_SUN else ["in turn"]
    return [_place(preset, k, count, unseen, size, sun) for k in range(count) for sun in suns]


def world_seed(preset: str, number: int, unseen: bool) -> int:
    """Return the seed of the world of a place: for judging, or one that anybody may look at."""
    if not unseen:
        return QUICK_SEED + number
    digest = hashlib.sha256(f"{FIXED_BY} {preset} {number}".encode()).digest()
    return BUILDING_SEEDS + 1 + int.from_bytes(digest[:4], "big")


def _place(name: str, k: int, count: int, unseen: bool, size: str | None, sun: str) -> Place:
    settings = [f"seed={world_seed(name, k, unseen)}", *([f"render.size={size}"] if size else [])]
    height = SUNS_DEG[k % len(SUNS_DEG)] if sun == "in turn" else float(sun.removesuffix("°"))
    if name != _ROUND_THE_FIRE:
        settings.append(f"light.sun_elevation={height:g}")
    if name == _FLIGHT:
        frame = round(1 + k * (_LAST_FRAME - 1) / max(count - 1, 1))
        return Place(name, k, sun, (*settings, "view.detail=1"), frame)
    camera, turn = load_preset(name, ()).camera, k * 360 / 8
    settings.append(f"camera.heading={math.fmod(camera.heading + turn, 360.0):g}")
    if name == _ROUND_THE_FIRE:
        (x, y), a = camera.position, math.radians(turn)
        east, north = x * math.cos(a) + y * math.sin(a), y * math.cos(a) - x * math.sin(a)
        settings.append(f"camera.position=[{east:.6f}, {north:.6f}]")
    return Place(name, k, sun, tuple(settings))


def band_edges(preset: Preset) -> np.ndarray:
    """Return the edges of a preset's bands of distance, (bands + 1,) [m].

    They are even in the logarithm, from twice the height of the eye to where air leaves 2 % of the
    contrast, or the ground ends. The first band then begins at the eye, and the last has no end.
    """
    farthest = min(preset.air.visibility or np.inf, preset.terrain.reach)
    edges = np.geomspace(2 * preset.camera.height, farthest, BANDS + 1)
    edges[0], edges[-1] = 0.0, float(SKY_Z)
    return edges


def shipped(scene: Scene, frame: int, variant: str) -> FrameInput:
    """Return what a user renders of a frame."""
    return scene.input(frame, variant)


def redrawn(world: World) -> World:
    """Return a world on the same ground, with the objects of its fields drawn from other seeds."""
    fields = {each.name: replace(each, seed=each.seed + 1) for each in world.fields}
    dust = tuple(replace(each, walkers=fields[each.walkers.name]) for each in world.dust)
    return replace(world, fields=tuple(fields.values()), dust=dust)


def cases(
    presets: Mapping[str, int],
    size: str | None,
    unseen: bool,
    samples: Sequence[int],
    light_passes: int,
    reference_bytes: int,
) -> list[Case]:
    """Return every place of every preset under each of its suns.

    All first places come first, so that a run that is stopped has seen some of every preset.
    """
    looks = Looks(tuple(samples), light_passes)
    every = (places(name, count, unseen, size) for name, count in presets.items())
    return [
        partial(measure, place, looks, choose(), reference_bytes)
        for place in sorted(chain(*every), key=lambda place: place.number)
    ]


def measure(place: Place, looks: Looks, variant: str, reference_bytes: int, seed: int) -> Point:
    """Look at one place as shipped, redrawn, and at its reference, of so many bytes at most.

    ``seed`` is that of the pictures' samples. Needs two counts of samples or more.
    """
    scene = Scene(place.load())
    fine = scene.with_preset(reference_preset(scene.preset, (place.frame,), reference_bytes))
    edges_m = band_edges(scene.preset)

    def seen(frame_input: FrameInput, *firsts: int) -> Seen:
        quality = replace(frame_input.quality, seed=seed, spp=max(looks.samples))
        return look(replace(frame_input, quality=quality), looks, edges_m, *firsts)

    whole = seen(fine.input(place.frame, variant), REFERENCE, TESTED)
    tested = seen(shipped(scene, place.frame, variant), TESTED)
    compared = {"tested": tested.pictures[0], "floor": whole.pictures[1]}
    if scene.world.fields:
        other = scene.with_world(redrawn(scene.world))
        compared["ceiling"] = seen(other.input(place.frame, variant), TESTED).pictures[0]
    bands = {"tested": tested, "reference": whole}
    if place.sun in CONVERGENCE:
        half = fine.preset.view.model_copy(update={"detail": 2 * fine.preset.view.detail})
        coarser = fine.with_preset(fine.preset.model_copy(update={"view": half}))
        bands["coarser"] = seen(coarser.input(place.frame, variant), TESTED)
        compared["coarser"] = bands["coarser"].pictures[0]
    found = {
        "place": [place.number],
        "world_seed": [scene.preset.seed],
        "reference_ppm": [round(1e6 * fine.preset.view.detail)],
        "sticks": [tested.sticks],
        "triangles": [tested.triangles],
    }
    case = {"topic": "stills", "preset": place.preset, "sun": place.sun}
    samples = (*columns(found), *_flip_columns(looks, compared, whole.pictures[0]))
    return Point(case, samples=(*samples, *_band_columns(bands, edges_m)))


def _flip_columns(
    looks: Looks, compared: Mapping[str, tuple[Radiance, ...]], whole: tuple[Radiance, ...]
) -> Iterator[Column]:
    for which, pictures in compared.items():
        for spp, each in zip(looks.samples, flips(pictures, whole), strict=True):
            yield Column("flip_ppm", [round(1e6 * each)], {"picture": which, "samples": spp})


def _band_columns(bands: Mapping[str, Seen], edges_m: np.ndarray) -> Iterator[Column]:
    """Yield luminance [10⁻⁶], rays, and powers of contrast [10⁻⁹] of every band."""
    for which, seen in bands.items():
        for of, sums in (("land", seen.land), ("things", seen.things)):
            yield from sums_by_band("light", sums.light, {"picture": which, "of": of})
            yield from sums_by_band("rays", sums.rays, {"picture": which, "of": of}, 1)
        one, other = seen.pictures[0][:2]
        power = contrast_power(one, other, bands["reference"].Z, edges_m)
        for octave, row in zip(OCTAVES_PX, power, strict=True):
            yield from sums_by_band("power", row, {"picture": which, "octave": octave}, 1e-9)


def contrast_power(
    one: Radiance, other: Radiance, Z: np.ndarray, edges_m: np.ndarray
) -> np.ndarray:
    """Sum squared contrast over the pixels of each band, by octave, (octaves, bands).

    Both pictures are of one scene with independent samples, so that their product is without noise
    on average. Contrast is the difference of two blurs over the wider (Peli, "Contrast in complex
    images", JOSA A 7(10), 1990); a blur at p pixels halves what repeats every p pixels.
    """
    land = Z < SKY_Z
    band = np.digitize(Z[land].astype(np.float64), edges_m[1:-1])
    contrasts = []
    for picture in (one, other):
        light = picture @ LUMINANCE
        sigma = [math.sqrt(math.log(2) / 2) / math.pi * p for p in (*OCTAVES_PX, 32)]
        blurs = [gaussian_filter(light, each, mode="nearest") for each in sigma]
        contrasts.append([(fine - wide)[land] / wide[land] for fine, wide in pairwise(blurs)])
    products = (a * b for a, b in zip(*contrasts, strict=True))
    return np.array([np.bincount(band, each, len(edges_m) - 1) for each in products])
