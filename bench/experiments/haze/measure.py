"""Which parts does haze hide, of which size, and does the law know how many? (§2.1, §4.1)

The derivation in docs/method.md says that haze takes big far parts and hardly any small near ones:
a part is gone past ln(C₀·max S)/β, 1.3 V to 2 V, and only what is large would be displayed from
there.
"""

from dataclasses import dataclass, replace

from bench.old_experiment import Effort
from bench.part_sizes import (
    SizeCounts,
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
from bench.records.records import Column, Point
from lod.air import Air, least_extinction
from lod.view import View
from lod.viewing import STANDARD_DISPLAY, STANDARD_EYE, BlurWidths, ViewingConditions, blur_widths

VISIBILITIES_M = (500.0, 1e3, 2e3, 5e3, 1e4, 2e4, 5e4)

CASES = (
    ("figure", "nobody", 640),
    ("figure", "eye", 640),
    ("tree", "nobody", 640),
    ("tree", "eye", 640),
    ("tree", "nobody", 1920),
)
"""The species, the viewer, and the width of the picture [px].

For ``nobody`` in particular only what is invisible at any size is gone; ``eye`` looks at a display
of 67 pixels per degree.
"""


@dataclass(frozen=True)
class Case:
    """A species, who looks, the width of the picture [px], and how many fields are measured."""

    species: str
    viewer: str
    width: int
    fields: int
    visibilities_m: tuple[float, ...] = VISIBILITIES_M


def cases(effort: Effort) -> list[Case]:
    """Return every species and viewer; each is seen through every air."""
    return [Case(*each, effort["fields"]) for each in CASES]


def measure(case: Case, seed: int) -> list[Point]:
    """Count parts of fields in haze of each visibility and, at the same m, in clear air."""
    seeds = [seed_of(case.species, seed, index) for index in range(case.fields)]
    _, clear = views_of(case.viewer, case.width, case.visibilities_m[0])
    things = prototypes_with(case.species, None), density_of(case.species, clear.m)
    unhazed = [count_sizes(*things, clear, each, case.visibilities_m) for each in seeds]
    made = []
    for row, visibility in enumerate(case.visibilities_m):
        hazy, _ = views_of(case.viewer, case.width, visibility)
        seen = [count_sizes(*things, hazy, each, (visibility,)) for each in seeds]
        named = {k: getattr(case, k) for k in ("species", "viewer", "width")}
        made.append(
            Point(
                {**named, "visibility": visibility, "m": hazy.m},
                tuple(
                    each
                    for air, view in (("hazy", hazy), ("clear", clear))
                    for each in size_predictions(predicted_sizes(*things, view), air=air)
                ),
                (*_columns("hazy", seen, 0), *_columns("clear", unhazed, row)),
            )
        )
    return made


def views_of(viewer: str, width: int, visibility_m: float) -> tuple[View, View]:
    """Return views in haze and in clear air that have one detail angle m: only haze differs."""
    theta, watched = camera(width).pixel_angle, viewer == "eye"
    widths = blur_widths(theta, STANDARD_DISPLAY, STANDARD_EYE) if watched else BlurWidths(theta)
    sight = ViewingConditions(widths, least_extinction(Air(visibility_m)), acuity=watched)
    return view_through(sight, width), view_through(replace(sight, extinction=0.0), width)


def _columns(air: str, seen: list[SizeCounts], row: int) -> tuple[Column, ...]:
    """Make columns of the parts of every size, and of those nearer than the visibility."""
    near = [each.near_counts[row] for each in seen]
    return (*size_columns(seen, air=air), Column("parts_nearer_than_V", near, {"air": air}))
