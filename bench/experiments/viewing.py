"""What do air, display, eye, motion and lens hide, and does the law know how much?

Sources are §2.1, §4.1 and §5.2 of the paper.

``haze`` takes big far parts and hardly any small near ones (docs/method.md): a part is gone past
ln(C₀·max S)/β, 1.3 V to 2 V, and only what is large would be displayed from there.

``eye`` keeps the picture 640 pixels wide, in clear air, and only how closely it is looked at
changes. Two things can leave a part out: blur, θ_eff² = θ_pixel² + θ_eye², and too little contrast
for its fineness (Barten's sensitivity, which has the eye's blur in it). Each is measured alone,
then both.

``motion`` (``bench.motion_cuts``) cuts `meadow` by size and distance alone and by motion as well;
``defocus`` (``bench.lens_cuts``) looks at `crowd` through a lens of 50 mm.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import numpy as np

from bench.experiment import Case, Experiment, Topic
from bench.images.differences import LEAST_PAIRS, errors, one_sided_excess
from bench.images.equal_error import EQUAL_ERROR
from bench.lens_cuts import (
    BANDS_M,
    F_STOP,
    FOCUS_M,
    LENS_CUTS,
    measure_lens_fields,
    measure_lens_parts,
    measure_lens_pictures,
)
from bench.motion_cuts import FAST, measure_field, measure_pictures
from bench.part_sizes import (
    BOUNDS_M,
    COARSE_M,
    DENSITY,
    SIZES,
    camera,
    count_sizes,
    density_of,
    part_counts,
    predicted_parts,
    predicted_sizes,
    prototypes_with,
    seed_of,
    shares_kept,
    size_columns,
    size_predictions,
    view_through,
)
from bench.plots import Curve, Plot, curves, estimated
from bench.records.claims import UNREPLICATED, Claim, at_least, at_most, claim, equals, within
from bench.records.records import Column, Point, Prediction, Record, grouped, where
from bench.statistics.estimates import Estimate, one_sided_mean, two_sided_mean, two_sided_share
from lod.air import Air, least_extinction
from lod.arrays import Reals
from lod.eye import Display
from lod.view import View
from lod.viewing import STANDARD_DISPLAY, STANDARD_EYE, BlurWidths, ViewingConditions, blur_widths
from scenes.render.variants import choose

# Haze.

VISIBILITIES_M = (500.0, 1e3, 2e3, 5e3, 1e4, 2e4, 5e4)
HAZE_CASES = (
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


def haze_views(viewer: str, width: int, visibility_m: float) -> tuple[View, View]:
    """Return views in haze and in clear air that have one detail angle m: only haze differs."""
    theta, watched = camera(width).pixel_angle, viewer == "eye"
    widths = blur_widths(theta, STANDARD_DISPLAY, STANDARD_EYE) if watched else BlurWidths(theta)
    sight = ViewingConditions(widths, least_extinction(Air(visibility_m)), acuity=watched)
    return view_through(sight, width), view_through(replace(sight, extinction=0.0), width)


def measure_haze(
    species: str,
    viewer: str,
    width: int,
    fields: int,
    seed: int,
    visibilities_m: tuple[float, ...] = VISIBILITIES_M,
) -> list[Point]:
    """Count parts of fields in haze of each visibility and, at the same m, in clear air."""
    seeds = [seed_of(species, seed, index) for index in range(fields)]
    _, clear = haze_views(viewer, width, visibilities_m[0])
    things = prototypes_with(species, None), density_of(species, clear.m)
    unhazed = [count_sizes(*things, clear, each, visibilities_m) for each in seeds]

    def parts(air: str, seen: list[Any], row: int) -> tuple[Column, ...]:
        near = [nearer[row] for _, nearer in seen]
        sizes = size_columns([by_size for by_size, _ in seen], air=air)
        return (*sizes, Column("parts_nearer_than_V", near, {"air": air}))

    made = []
    for row, visibility in enumerate(visibilities_m):
        hazy, _ = haze_views(viewer, width, visibility)
        seen = [count_sizes(*things, hazy, each, (visibility,)) for each in seeds]
        kind = {"species": species, "viewer": viewer, "width": width}
        predicted = tuple(
            each
            for air, view in (("hazy", hazy), ("clear", clear))
            for each in size_predictions(predicted_sizes(*things, view), air=air)
        )
        named = {"topic": "haze", **kind, "visibility": visibility, "m": hazy.m}
        made.append(
            Point(named, predicted, (*parts("hazy", seen, 0), *parts("clear", unhazed, row)))
        )
    return made


# Display and eye.

PIXELS_PER_DEGREE = (20.0, 30.0, 45.0, 67.0, 90.0, 120.0)
FAINT = 0.1  # the contrast that replaces each part's own for some viewers: the least class

EYE_WIDTH = 640
VIEWERS = {
    "blur": "blur alone",
    "contrast": "contrast alone",
    "faint": "contrast alone, all of 0.1",
    "both": "both, all of 0.1",
}


def eye_views(ppd: float) -> dict[str, tuple[View, float | None]]:
    """Return views by viewer, and the contrast that each gives all parts; None = their own."""
    theta, shown = camera(EYE_WIDTH).pixel_angle, Display(ppd)
    pixel, blur = BlurWidths(theta), blur_widths(theta, shown, STANDARD_EYE)

    def view(widths: BlurWidths, acuity: bool) -> View:
        return view_through(ViewingConditions(widths, 0.0, shown, STANDARD_EYE, acuity), EYE_WIDTH)

    return {
        "ideal": (view(pixel, False), None),
        "blur": (view(blur, False), None),
        "contrast": (view(pixel, True), None),
        "faint": (view(pixel, True), FAINT),
        "both": (view(blur, True), FAINT),
    }


def measure_eye(species: str, ppd: float, fields: int, seed: int) -> Point:
    """Count the parts that every viewer sees in fields of a display of pixels per degree."""
    seeds = [seed_of(f"{species} {ppd}", seed, index) for index in range(fields)]
    density = density_of(species, COARSE_M)
    samples: list[Column] = []
    predicted: list[Prediction] = []
    for viewer, (view, contrast) in eye_views(ppd).items():
        things = prototypes_with(species, contrast)
        counts = [count_sizes(things, density, view, each)[0] for each in seeds]
        samples += size_columns(counts, viewer=viewer)
        predicted += size_predictions(predicted_sizes(things, density, view), viewer=viewer)
    widths = blur_widths(1.0, Display(ppd), STANDARD_EYE)
    named = {"species": species, "pixels_per_degree": ppd, "blur_px": widths.effective}
    return Point({"topic": "eye", **named}, tuple(predicted), tuple(samples))


# Motion and lens.


def _motion_cases(fields: int, samples_per_pixel: int) -> list[Case]:
    rest = choose(), samples_per_pixel
    return [
        *(partial(measure_field, number) for number in range(fields)),
        *(partial(measure_pictures, pair, *rest) for pair in range(LEAST_PAIRS)),
    ]


def _defocus_cases(fields: int, size: str, spp: Sequence[int]) -> list[Case]:
    pairs, rest = range(LEAST_PAIRS if spp else 0), (size, tuple(spp), choose())
    pictures = (partial(measure_lens_pictures, k, *rest) for k in pairs)
    frame = partial(measure_lens_parts, "480x270")
    return [partial(measure_lens_fields, fields), frame, *pictures]


# Claims, from raw points alone.

JUDGED_AT_M, JUDGED_AT_PPD = 2e3, 67.0
"""The visibility and the pixels per degree at which shares are claimed."""

BIG, SMALL = SIZES[len(BOUNDS_M) - 1 :], SIZES[: len(BOUNDS_M) - 1]
"""The classes of size over and under 1 m."""

_LAW, _DERIVED = "§2.1, §4.1", "derived: docs/method.md"
HAZE_KIND = "species", "viewer", "width"  # the keys that points of different visibility share

_row = partial(claim, unit="field", source=_DERIVED, alone=UNREPLICATED)
_check = partial(_row, source=_LAW, kind="verification")


def _haze_claims(points: Sequence[Point]) -> Iterator[Claim]:
    for kind, chosen in grouped(points, *HAZE_KIND).items():
        yield from _of_haze(dict(zip(HAZE_KIND, kind, strict=True)), chosen)


def _of_haze(kind: dict[str, Any], points: list[Point]) -> Iterator[Claim]:
    of = {**kind, "width": f"{kind['width']} px"}
    found, law = shares_kept(points, {"air": "hazy"}, {"air": "clear"})
    estimand = "share of parts that haze leaves, all visibilities"
    yield _check(estimand, within(round(law, 6), 0.02), of, found)
    near, lost = (
        np.sum([part(p, "clear") - part(p, "hazy") for p in points], axis=0)
        for part in (
            lambda p, air: p.values("parts_nearer_than_V", air=air),
            lambda p, air: part_counts(p, air=air),
        )
    )
    estimand, nearer = (
        "share of the parts lost that were nearer than V",
        two_sided_share(near, lost),
    )
    yield _check(estimand, at_most(0.01), of, nearer, source=_DERIVED)
    for point in where(points, visibility=JUDGED_AT_M):
        at = {**of, "V": "2 km"}
        if kind["species"] == "tree":
            kept, _ = shares_kept([point], {"air": "hazy"}, {"air": "clear"}, BIG)
            ends = 1 - kept.value, 1 - kept.high, 1 - kept.low
            gone = Estimate(*ends, kept.standard_error, 1.0, kept.rows)
            yield _row("share of parts over 1 m that haze hides", at_least(0.5), at, gone)
        clear = part_counts(point, SMALL, air="clear")
        small = two_sided_share(clear - part_counts(point, SMALL, air="hazy"), clear)
        yield _row("share of parts under 1 m that haze hides", at_most(0.05), at, small)


def _eye_claims(points: Sequence[Point]) -> Iterator[Claim]:
    for (species,), chosen in grouped(points, "species").items():
        for viewer, label in VIEWERS.items():
            found, law = shares_kept(chosen, {"viewer": viewer}, {"viewer": "ideal"})
            estimand = "share of parts that display and eye leave, all displays"
            of, bound = {"species": species, "viewer": label}, within(round(law, 6), 0.02)
            yield _check(estimand, bound, of, found)
        for point in where(chosen, pixels_per_degree=JUDGED_AT_PPD):
            at = {"species": species, "display": f"{JUDGED_AT_PPD:g} pixels per degree"}
            left, _ = shares_kept([point], {"viewer": "blur"}, {"viewer": "ideal"})
            share = round(point.case["blur_px"] ** -2, 6)
            estimand = "share of parts that blur leaves, against 1/θ_eff²"
            yield _check(estimand, within(share, 0.01), at, left)
            blurred = part_counts(point, viewer="blur")
            lost = two_sided_share(blurred - part_counts(point, viewer="both"), blurred)
            estimand = "share of what blur leaves that a contrast of 0.1 hides"
            yield _check(estimand, at_most(0.01), at, lost, source=_DERIVED)


def _is_fast(point: Point) -> bool:
    return asdict(FAST).items() <= point.case.items()


def parts(point: Point, cut: str) -> Reals:
    """Return the parts that every field displays by a cut, (fields,)."""
    return point.values("parts", cut=cut)


def left_out(point: Point) -> Estimate:
    """Estimate the share of the parts left by size and distance that motion leaves out."""
    spatial = parts(point, "spatial")
    return two_sided_share(spatial - parts(point, "motion"), spatial)


def one_sided_excess_flip(point: Point) -> Estimate:
    """Estimate excess FLIP, with one-sided 95 % bounds."""
    return one_sided_excess(*(point.values(k) / 1e6 for k in ("flip", "flip_floor")))


def _motion_claims(points: Sequence[Point]) -> Iterator[Claim]:
    hides, pan = "share of parts that motion hides", {"camera": "pan of 90°/s, 180° shutter"}
    pictured = False
    for point in (p for p in points if p.case["world"] != "picture"):
        turn, speed = (point.case[k] for k in ("turn", "speed"))
        if point.case["world"] == "finite":
            unpruned, spatial, motion = (
                parts(point, cut) for cut in ("everything", "spatial", "motion")
            )
            found = two_sided_share(unpruned - spatial, unpruned - motion)
            estimand = "share of the parts left out that size and distance leave out"
            at = {**pan, "world": "400 m"}
            yield _row(estimand, within(0.95, 0.05), at, found, source="Reddy 1997")
        elif turn == speed == 0:
            rest = {"camera": "at rest"}
            yield _check(hides, equals(0), rest, left_out(point), source=_DERIVED)
        elif _is_fast(point):  # with less, that its picture stays as it is would say nothing
            made = _row(hides, at_least(0.1), pan, left_out(point))
            pictured = made.verdict == "holds"
            yield made
        elif speed == 1.4:
            yield _row(hides, at_most(0.01), {"camera": "walk, 1.4 m/s"}, left_out(point))
    fast = {p.case["cut"]: p for p in where(points, world="picture") if _is_fast(p)}
    estimand = "excess FLIP over the picture cut by size and distance"
    of_pair = partial(_row, unit="pair of seeds")
    if pictured and "motion" in fast:
        found = one_sided_excess_flip(fast["motion"])
        yield of_pair(estimand, at_most(EQUAL_ERROR), {**pan, "cut": "by motion"}, found)
    if pictured and "planted" in fast:
        found, at = one_sided_excess_flip(fast["planted"]), {**pan, "cut": "planted, τ = 4 px"}
        yield of_pair(estimand, at_least(EQUAL_ERROR), at, found, kind="verification")


def _defocus_claims(points: Sequence[Point]) -> Iterator[Claim]:
    lens = {"lens": f"50 mm, f/{F_STOP:g}, focus at {FOCUS_M:g} m"}
    for point in where(points, what="fields"):
        found = two_sided_mean(point.values("parts") / point.prediction("parts"))
        yield _check("parts displayed through a lens ÷ predicted", within(1, 0.01), lens, found)
    if pictures := {p.case["cut"]: p for p in where(points, what="picture")}:
        aware, unaware = (errors(pictures[cut]) for cut in LENS_CUTS)
        estimand = "FLIP to unpruned, cut that knows of the lens − cut that does not"
        found, bound = one_sided_mean(aware - unaware), at_most(EQUAL_ERROR)
        yield _row(estimand, bound, lens, found, unit="pair of seeds")


# Plots.


def _haze_plots(record: Record) -> Iterator[Plot]:
    for kind, points in grouped(record.points, *HAZE_KIND).items():
        yield _haze_plot(points, *kind)


def _eye_plots(record: Record) -> Iterator[Plot]:
    for (species,), points in grouped(record.points, "species").items():
        drawn = []
        for viewer, label in VIEWERS.items():
            keys = {"viewer": viewer}, {"viewer": "ideal"}
            x = [point.case["pixels_per_degree"] for point in points]
            drawn.append(_left_curve(label, x, [shares_kept([p], *keys) for p in points]))
        caption = (
            "Parts displayed for an eye before a display, over those displayed for an ideal eye at "
            "one pixel of detail; clear air, a picture 640 pixels wide. Dashed: predicted."
        )
        title = f"Parts that display and eye leave: {species}"
        axis = "pixels per degree of sight", "share of the parts that is left"
        yield curves(f"eye-{species}", title, caption, axis, drawn)


def _motion_plots(record: Record) -> Iterator[Plot]:
    if pans := where(record.points, world="endless", speed=0.0, shutter=180.0):
        found = [two_sided_share(parts(p, "motion"), parts(p, "spatial")) for p in pans]
        drawn = estimated("meadow, 640 px", [point.case["turn"] for point in pans], found)
        words = ", ".join(f"{y:.3g} at {x:g}°/s" for x, y in zip(drawn.x, drawn.y, strict=True))
        caption = f"Parts kept when motion is counted, shutter 180°, 24 frames/s: {words}."
        axis = "speed of the pan (degrees/s)", "parts kept ÷ by size and distance alone"
        title = "Parts that a pan hides"
        yield curves("motion", title, caption, axis, [drawn], ("linear", "log"))


def _defocus_plots(record: Record) -> Iterator[Plot]:
    if seen := {p.case["cut"]: p for p in where(record.points, what="parts")}:
        drawn = []
        for cut in LENS_CUTS:
            counts = [seen[cut].column("parts", **{"from": low})[0] for low in BANDS_M[:-1]]
            drawn.append(Curve(cut, [max(low, 3.0) for low in BANDS_M[:-1]], counts))
        caption = "Parts of `crowd` by distance, of cuts that know of the lens or do not."
        axis = "near end of the band of distance (m)", "parts displayed"
        yield curves("defocus", "Parts that a lens hides", caption, axis, drawn)


def _left_curve(label: str, x: list[float], left: list[tuple[Estimate, float]]) -> Curve:
    return Curve(label, x, [e.value for e, _ in left], line=(x, [law for _, law in left]))


def _haze_plot(points: list[Point], species: str, viewer: str, width: int) -> Plot:
    drawn, V = [], [point.case["visibility"] for point in points]
    for size in SIZES:
        counts = part_counts(points[0], [size], air="clear")
        if counts.any() and predicted_parts(points[0], [size], air="clear") > 0:
            keys = {"air": "hazy"}, {"air": "clear"}, [size]
            drawn.append(_left_curve(size, V, [shares_kept([p], *keys) for p in points]))
    who = "no eye" if viewer == "nobody" else "an eye at 67 pixels per degree"
    caption = (
        f"Parts of each size P displayed in haze, over those displayed in clear air at the same m; "
        f"{who}, a picture {width} pixels wide, {len(points[0].samples[0].values)} fields. Dashed: "
        "predicted."
    )
    title, axis = f"Parts that haze leaves: {species} ({who}, {width} px)", "visibility V (m)"
    name = f"haze-{species}-{viewer}-{width}"
    return curves(name, title, caption, (axis, "share of the parts that is left"), drawn)


EXPERIMENT = Experiment(
    name="viewing",
    question="How much do air, display, eye, motion and lens hide, and does the law know it?",
    version=1,
    topics={
        "haze": Topic(
            about="parts of each size that haze hides, from V = 0.5 to 50 km, against the law",
            cases=lambda fields: [partial(measure_haze, *each, fields) for each in HAZE_CASES],
            claims=_haze_claims,
            plots=_haze_plots,
            full={"fields": 80},
            quick={"fields": 12},
            seconds=(80.0, 60.0),
        ),
        "eye": Topic(
            about="parts that display and eye leave out, from 20 to 120 pixels per degree",
            cases=lambda fields: [
                partial(measure_eye, species, ppd, fields)
                for species in DENSITY
                for ppd in PIXELS_PER_DEGREE
            ],
            claims=_eye_claims,
            plots=_eye_plots,
            full={"fields": 60},
            quick={"fields": 10},
            seconds=(40.0, 30.0),
        ),
        "motion": Topic(
            about="parts that an open shutter hides, and whether the blurred picture misses them",
            cases=_motion_cases,
            claims=_motion_claims,
            plots=_motion_plots,
            full={"fields": 12, "samples_per_pixel": 576},
            quick={"fields": 4, "samples_per_pixel": 32},
            seconds=(270.0, 180.0),
        ),
        "defocus": Topic(
            about="parts that a lens hides, against the law, and what that costs the picture",
            cases=_defocus_cases,
            claims=_defocus_claims,
            plots=_defocus_plots,
            full={"fields": 24, "size": "160x90", "spp": [16, 64, 256]},
            quick={"fields": 8, "size": "48x27", "spp": [4, 16]},
            seconds=(600.0, 60.0),
            apart=True,
        ),
    },
    caveats=(
        "Haze and eye: flat ground and an eye 1.6 m up that looks all round; nothing hides "
        "anything. What is gone is what Barten's standard observer, 20 to 30 years old, could not "
        "see on a display of 100 cd/m²; a tone curve that steepens contrast shows more.",
        "Shares that haze hides depend on m·V alone, as long as contrast classes are the same: a "
        "finer picture shows more far parts for haze to take.",
        "A part is a half-period of a grating of its own size; what eyes make of edges, colour "
        "and movement is not in it.",
        "Motion: `meadow`, where nothing moves by itself, 640 pixels wide, 24 frames a second; "
        "pictures are windows about the horizon, of one place. The share of a gain that size and "
        "distance have depends on how much there is to leave out: here everything in a square of "
        "400 m, out of view as well.",
        "Defocus: one lens, of `crowd` in a window of 150 m.",
    ),
    rendered=True,
    order=30,
)
