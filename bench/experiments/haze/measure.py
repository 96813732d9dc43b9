"""What does haze take, of which size, and does the law know? (§2.1, §4.1)

A derivation says that haze takes big far parts and hardly any small near ones: a part is gone past
ln(C₀·max S)/β, some 1.7 V, and only what is large would have been displayed from there.
"""

import time
from dataclasses import replace

from bench.experiments.haze.claims import judge
from bench.fields.part_sizes import (
    SIZES,
    SizeCounts,
    camera,
    count_sizes,
    density_of,
    predicted_sizes,
    prototypes_with,
    scene_hash,
    seed_of,
    view_through,
)
from bench.records.provenance import provenance
from bench.records.records import Point, Record
from bench.runner.dask_cases import CaseExecutor, serial_executor
from bench.runner.experiment import Progress, silent
from bench.runner.run_cases import make_record, run_cases
from lod.atmosphere.air import Air, least_extinction
from lod.pruning.view import View
from lod.vision.blur_cascade import BlurWidths, blur_widths
from lod.vision.viewer import STANDARD_DISPLAY, STANDARD_EYE, ViewingConditions

NAME, VERSION = "haze", 1

VISIBILITIES_M = (500.0, 1e3, 2e3, 5e3, 1e4, 2e4, 5e4)

CASES = (
    ("figure", "nobody", 640),
    ("figure", "eye", 640),
    ("tree", "nobody", 640),
    ("tree", "eye", 640),
    ("tree", "nobody", 1920),
)
"""Species; who looks; width of the picture [px]. Nobody in particular: what is invisible at any
size is gone. An eye: before a display of 67 pixels per degree."""

FIELDS, QUICK_FIELDS = 80, 12


def run(
    quick: bool = False,
    progress: Progress = silent,
    seed: int = 0,
    each: CaseExecutor = serial_executor,
) -> Record:
    """Count every size of part through every air, and judge every claim."""
    start, fields = time.perf_counter(), QUICK_FIELDS if quick else FIELDS
    cases = [(f"{s}, {who}, {px} px", (s, who, px, fields, seed)) for s, who, px in CASES]
    points = run_cases(progress, each, (measure, cases))
    return make_record(
        NAME,
        VERSION,
        quick=quick,
        provenance=provenance(scene_hash([point.case for point in points]), seed),
        points=points,
        claims=judge(points),
        notes={"fields": fields},
        start=start,
    )


def measure(species: str, viewer: str, width: int, fields: int, seed: int) -> list[Point]:
    """A point for each visibility: the same fields in haze and, at the same m, in clear air."""
    seeds = [seed_of(species, seed, index) for index in range(fields)]
    _, clear = views_of(viewer, width, VISIBILITIES_M[0])
    things = prototypes_with(species, None), density_of(species, clear.m)
    unhazed = [count_sizes(*things, clear, each, VISIBILITIES_M) for each in seeds]
    made = []
    for row, visibility in enumerate(VISIBILITIES_M):
        hazy, _ = views_of(viewer, width, visibility)
        seen = [count_sizes(*things, hazy, each, (visibility,)) for each in seeds]
        samples = _columns("hazy", seen, 0) | _columns("clear", unhazed, row)
        case = {"species": species, "viewer": viewer, "width": width, "visibility": visibility}
        means = {"hazy": predicted_sizes(*things, hazy), "clear": predicted_sizes(*things, clear)}
        predicted = {
            f"{a}, {s}": float(v) for a in means for s, v in zip(SIZES, means[a], strict=True)
        }
        made.append(Point({**case, "m": hazy.m}, predicted, samples))
    return made


def views_of(viewer: str, width: int, visibility_m: float) -> tuple[View, View]:
    """In haze and in clear air, with the same detail angle m, so that haze alone differs."""
    theta, watched = camera(width).pixel_angle, viewer == "eye"
    widths = blur_widths(theta, STANDARD_DISPLAY, STANDARD_EYE) if watched else BlurWidths(theta)
    sight = ViewingConditions(widths, least_extinction(Air(visibility_m)), acuity=watched)
    return view_through(sight, width), view_through(replace(sight, extinction=0.0), width)


def _columns(air: str, seen: list[SizeCounts], row: int) -> dict[str, list[int]]:
    """Parts of every size in every field, and those nearer than the visibility."""
    columns = zip(*(each.by_size for each in seen), strict=True)
    by_size = {f"{air}, {s}": list(c) for s, c in zip(SIZES, columns, strict=True)}
    return by_size | {f"{air}, nearer than V": [each.near_counts[row] for each in seen]}
