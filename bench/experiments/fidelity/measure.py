"""What does pruning do to the picture? (§1.2, §2.4)

Headline pictures show everything pruned at one pixel, and in every third field species and ground
alone, against one reference: FLIP at several counts of samples, and by bands of distance FLIP of
the same place, luminance and how many rays meet the band. Sweeps compare metrics: species pruned
over the reference's ground. Fields are the replicates: every column has a number for each.
"""

import gc
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bench.experiments.fidelity.pictures import pictures_of
from bench.experiments.fidelity.scene import (
    ALONE_EVERY,
    EVERYTHING,
    GRASS,
    GRASS_METRICS,
    GROUND,
    METRICS_TRIED,
    NOTHING,
    SPECIES,
    Field,
    displayed,
    edges,
    field_view,
    fields,
    parts_in,
    reference,
    swept_fields,
    world_of,
)
from bench.experiments.fidelity.shipped.displayed import Shown
from bench.experiments.fidelity.shipped.pictures import (
    REFERENCE,
    TESTED,
    Looks,
    Seen,
    flips_by_pixel,
    look,
)
from bench.old_experiment import Effort
from bench.records.records import NOTE, Column, Key, Point, columns
from bench.statistics.excess_flip import PIXELS_PER_DEGREE
from scenes.frame.frame_input import FrameInput
from scenes.render.variants import choose
from scenes.scene import frame_quality, preset_air
from scenes.world.light import sun_and_sky

Way = tuple[str, str, float]
"""What is pruned, by which metric, and at which detail [px]."""


@dataclass(frozen=True)
class Compared:
    """A field whose reference is compared with what is pruned in some ways.

    what  ``headline`` or ``sweep``
    """

    what: str
    field: Field
    ways: tuple[Way, ...]
    looks: Looks
    variant: str

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.what}, field {self.field.number}, {self.field.view}"


def cases(effort: Effort, metric: str | None = None) -> list[Compared]:
    """Return the headline pictures of every field, and the sweeps, with ``metric`` in them."""
    variant = choose()
    looks = Looks(tuple(effort["samples"]), effort["light_passes"])
    made = [Compared("headline", f, _ways(f), looks, variant) for f in fields(effort)]
    looks = Looks(tuple(effort["sweep_samples"]), 0)
    swept = swept_fields(effort)
    return made + [Compared("sweep", f, _sweep(f, effort, metric), looks, variant) for f in swept]


def _ways(field: Field) -> tuple[Way, ...]:
    alone = () if field.number % ALONE_EVERY else (NOTHING, SPECIES, GROUND)
    return tuple((pruned, "blake", 1.0) for pruned in (EVERYTHING, *alone))


def _sweep(field: Field, effort: Effort, metric: str | None) -> tuple[Way, ...]:
    grass = field.view == GRASS
    tried = (*(GRASS_METRICS if grass else METRICS_TRIED), *([metric] if metric else []))
    details = effort["grass_details" if grass else "details"]
    return tuple((SPECIES, name, detail) for name in tried for detail in details)


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, Any]:
    """Return how pictures were rendered, and pictures to look at."""
    pictures = pictures_of(fields(effort), choose(), effort["picture_spp"], seed)
    return {**effort.sizes, "pixels_per_degree": PIXELS_PER_DEGREE, NOTE: pictures}


def measure(case: Compared, seed: int) -> list[Point]:
    """Look at the reference of one field, then at each way to prune it: a point for each."""
    world, view = world_of(case.field, seed), field_view(case.field, seed)
    whole = _look(case, reference(world, view), seed, REFERENCE)
    made = []
    for way in case.ways:
        shown = displayed(world, view, *way)
        parts = parts_in(world, shown)
        seen = _look(case, shown, seed, TESTED)
        made.append(_point(case, seed, way, parts, seen, whole))
        del shown, seen
    return made


def _look(case: Compared, shown: Shown, seed: int, first: int) -> Seen:
    gc.collect()  # a scene that was built before is large
    preset = case.field.preset(seed)
    quality = replace(frame_quality(preset, case.variant), seed=seed, spp=max(case.looks.samples))
    camera = field_view(case.field, seed).camera
    light = preset_air(preset), sun_and_sky(preset)
    return look(FrameInput(camera, shown, *light, quality), case.looks, edges(), first)


def _point(case: Compared, seed: int, way: Way, parts: int, tested: Seen, whole: Seen) -> Point:
    """Make a point: FLIP [10⁻⁶], and for headlines what each band of distance shows."""
    preset = case.field.preset(seed)
    counted = {
        "field": [case.field.number],
        "world_seed": [preset.seed],
        "prototype_seed": [case.field.prototype_seed],
        "parts": [parts],
        "sticks": [tested.sticks],
        "triangles": [tested.triangles],
    }
    bands = np.digitize(whole.Z.astype(np.float64).ravel(), edges()[1:-1])
    found: list[Column] = []
    for k, flip in enumerate(flips_by_pixel(tested.pictures, whole.pictures)):
        keys: dict[str, Key] = {"samples": case.looks.samples[k], "number": k}
        found.append(Column("flip_ppm", [round(1e6 * float(flip.mean()))], keys))
        if case.what == "headline":
            found += _of_bands("flip_sum_ppm", np.bincount(bands, flip, len(edges()) - 1), keys)
    if case.what == "headline":
        found += _of_bands("pixels", np.bincount(bands, minlength=len(edges()) - 1) / 1e6, {})
        for which, seen in (("tested", tested), ("reference", whole)):
            found += _of_bands("light", seen.land.light, {"picture": which})
            found += _of_bands("rays", seen.land.rays / 1e6, {"picture": which})
    pruned, metric, detail = way
    named: dict[str, Any] = {"what": case.what, "view": case.field.view}
    named |= {"pruned": pruned, "metric": metric, "detail": detail}
    return Point(named, samples=(*columns(counted), *found))


def _of_bands(quantity: str, values: np.ndarray, keys: dict[str, Key]) -> Iterator[Column]:
    """Yield a column of 10⁻⁶ for each band."""
    for band, value in enumerate(values):
        yield Column(quantity, [round(1e6 * float(value))], keys | {"band": band})
