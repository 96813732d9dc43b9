"""What do a display and the eye before it leave out, from 20 to 120 pixels per degree? (§2.1)

The air is clear. The picture stays 640 pixels wide, and only how closely it is looked at changes.
Two things can leave a part out: blur, θ_eff² = θ_pixel² + θ_eye², and too little contrast for its
fineness (Barten's sensitivity, which has the eye's blur in it). Each is measured alone, then both.
"""

from dataclasses import dataclass

from bench.old_experiment import Effort
from bench.part_sizes import (
    COARSE_M,
    DENSITY,
    camera,
    count_sizes,
    density_of,
    predicted_sizes,
    prototypes_with,
    seed_of,
    size_columns,
    size_predictions,
    view_through,
)
from bench.records.records import Column, Point, Prediction
from lod.eye import Display
from lod.view import View
from lod.viewing import STANDARD_EYE, BlurWidths, ViewingConditions, blur_widths

PIXELS_PER_DEGREE = (20.0, 30.0, 45.0, 67.0, 90.0, 120.0)
FAINT = 0.1
"""The contrast that replaces each part's own for some viewers: the least class."""

WIDTH = 640


@dataclass(frozen=True)
class Case:
    """A species, the pixels per degree of the display, and how many fields are measured."""

    species: str
    pixels_per_degree: float
    fields: int


def cases(effort: Effort) -> list[Case]:
    """Return every species on every display."""
    return [Case(s, ppd, effort["fields"]) for s in DENSITY for ppd in PIXELS_PER_DEGREE]


def measure(case: Case, seed: int) -> Point:
    """Count the parts that every viewer sees in fields of a display."""
    species, ppd = case.species, case.pixels_per_degree
    seeds = [seed_of(f"{species} {ppd}", seed, index) for index in range(case.fields)]
    density = density_of(species, COARSE_M)
    samples: list[Column] = []
    predicted: list[Prediction] = []
    for viewer, (view, contrast) in viewers(ppd).items():
        things = prototypes_with(species, contrast)
        counts = [count_sizes(things, density, view, each) for each in seeds]
        samples += size_columns(counts, viewer=viewer)
        predicted += size_predictions(predicted_sizes(things, density, view), viewer=viewer)
    widths = blur_widths(1.0, Display(ppd), STANDARD_EYE)
    named = {"species": species, "pixels_per_degree": ppd, "blur_px": widths.effective}
    return Point(named, tuple(predicted), tuple(samples))


def viewers(ppd: float) -> dict[str, tuple[View, float | None]]:
    """Return views by viewer, and the contrast that each gives all parts; None = their own."""
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
