"""What do a display and the eye before it leave out, from 20 to 120 pixels per degree? (§2.1)

Clear air. The picture stays 640 pixels wide; what changes is how closely it is looked at. Two
things can leave a part out: blur, θ_eff² = θ_pixel² + θ_eye², and too little contrast for its
fineness (Barten's sensitivity, the eye's blur in it). Each is taken alone, then both together.
"""

import time

from bench.experiments.eye.claims import judge
from bench.fields.part_sizes import (
    COARSE_M,
    DENSITY,
    SIZES,
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
from lod.pruning.view import View
from lod.vision.blur_cascade import BlurWidths, blur_widths
from lod.vision.eye import Display
from lod.vision.viewer import STANDARD_EYE, ViewingConditions

NAME, VERSION = "eye", 1

PIXELS_PER_DEGREE = (20.0, 30.0, 45.0, 67.0, 90.0, 120.0)
FAINT = 0.1
"""A contrast that every part is given, in place of its own: the least class."""

WIDTH = 640
FIELDS, QUICK_FIELDS = 60, 10


def run(
    quick: bool = False,
    progress: Progress = silent,
    seed: int = 0,
    each: CaseExecutor = serial_executor,
) -> Record:
    """Count parts on every display, and judge every claim."""
    start, fields = time.perf_counter(), QUICK_FIELDS if quick else FIELDS
    cases = [
        (f"{species}, {ppd:g} pixels per degree", (species, ppd, fields, seed))
        for species in DENSITY
        for ppd in PIXELS_PER_DEGREE
    ]
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


def measure(species: str, ppd: float, fields: int, seed: int) -> Point:
    """Fields of their own for each display, each looked at by every viewer."""
    seeds = [seed_of(f"{species} {ppd}", seed, index) for index in range(fields)]
    density = density_of(species, COARSE_M)
    samples: dict[str, list[int]] = {}
    predicted: dict[str, float] = {}
    for viewer, (view, contrast) in viewers(ppd).items():
        things = prototypes_with(species, contrast)
        seen = [count_sizes(things, density, view, each).by_size for each in seeds]
        means = predicted_sizes(things, density, view)
        for row, size in enumerate(SIZES):
            samples[f"{viewer}, {size}"] = [counts[row] for counts in seen]
            predicted[f"{viewer}, {size}"] = float(means[row])
    widths = blur_widths(1.0, Display(ppd), STANDARD_EYE)
    case = {"species": species, "pixels_per_degree": ppd, "blur_px": widths.effective}
    return Point(case, predicted, samples)


def viewers(ppd: float) -> dict[str, tuple[View, float | None]]:
    """Views by viewer, and the contrast that each gives all parts; None = each part's own."""
    theta, display = camera(WIDTH).pixel_angle, Display(ppd)
    pixel, blur = BlurWidths(theta), blur_widths(theta, display, STANDARD_EYE)

    def view(widths: BlurWidths, acuity: bool) -> View:
        return view_through(ViewingConditions(widths, 0.0, display, STANDARD_EYE, acuity), WIDTH)

    return {
        "ideal": (view(pixel, False), None),
        "blur": (view(blur, False), None),
        "contrast": (view(pixel, True), None),
        "faint": (view(pixel, True), FAINT),
        "both": (view(blur, True), FAINT),
    }
