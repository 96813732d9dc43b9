"""What does pruning do to pictures, by error, brightness, coverage and frequency? (§2.1, §2.4)

``fidelity`` compares pictures of unseen fields with a much finer reference, and metrics at equal
error; ``fidelity_shipped`` does so for presets at their shipped settings; ``cover`` follows
luminance and coverage to 5 km against the unpruned scene, with far cover and without; ``spectrum``
holds powers of the difference against the cut-off of m; ``pixels`` counts an object's parts against
the pixels that it covers; ``colonnade`` is Leonardo's row of columns.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import pairwise

import numpy as np

from bench.experiment import Experiment, Topic
from bench.images import colonnade, cover, fields, pixels, shipped, spectrum
from bench.images.differences import band_name, coverage_ratio, errors, luminance_ratio, same_place
from bench.images.equal_error import EQUAL_ERROR, GRASS_ERROR, Reached, equal_error
from bench.plots import Curve, Plot, curves, estimated
from bench.records.claims import EXACT, UNREPLICATED, Claim, at_most, claim, equals, within
from bench.records.records import NOTE, Point, Record, grouped, where
from bench.statistics.estimates import (
    Estimate,
    exactly,
    one_sided_mean,
    two_sided_mean,
    two_sided_paired_ratio,
    two_sided_quantile,
    two_sided_share,
)

MOST_ERROR = EQUAL_ERROR
"""The FLIP to a reference up to which a picture passes."""

BAND_MARGIN = 0.02
"""How far a band's luminance and coverage may be from the reference's, as a share."""

CONTROL = 0.002
"""How far from 0 the fit may find the error of a reference against itself."""

_claim = partial(claim, source="§2.4")


def _fidelity_claims(points: Sequence[Point]) -> Iterator[Claim]:
    of_field = partial(_claim, unit="field")
    for (view,), chosen in grouped(where(points, what="headline"), "view").items():
        ways = {p.case["pruned"]: p for p in chosen}
        control, bound = errors(ways[fields.NOTHING]), within(0, CONTROL)
        if len(control) > 1:
            found = two_sided_mean(control)
            yield of_field("FLIP of the reference to itself", bound, {"view": view}, found)
        for pruned, words in fields.PRUNED.items():
            if pruned in ways and len(wrong := errors(ways[pruned])) > 1:
                of = {"view": view, "metric": "blake", "τ": "1 px", "pruned": words}
                shown, found = pruned == fields.EVERYTHING and view != "hazy", one_sided_mean(wrong)
                bound = at_most(MOST_ERROR)
                yield of_field("FLIP to the reference", bound, of, found, headline=shown)
        point = ways[fields.EVERYTHING]
        for band in fields.judged_bands(point):
            of = {"view": view, "distance": band_name(fields.EDGES_M, band)}
            for estimand, ratio in (
                ("luminance ratio to the reference", luminance_ratio(point, band)),
                ("coverage ratio to the reference", coverage_ratio(point, band)),
            ):
                yield of_field(estimand, within(1, BAND_MARGIN), of, ratio)
            if (same := same_place(point, band)) is not None:
                yield of_field("FLIP in the same places", at_most(MOST_ERROR), of, same)
    for (view,), chosen in grouped(where(points, what="sweep"), "view").items():
        found_by = _swept(chosen)
        ours = found_by["blake"]
        for other in found_by.values():
            if other is not ours and ours.found and other.found:
                estimand = f"parts at equal FLIP, blake ÷ {other.metric}"
                at = {"view": view, "FLIP": _compared_at(view)}
                yield of_field(estimand, at_most(1), at, ours.parts_over(other))


def _compared_at(view: str) -> float:
    return GRASS_ERROR if view == fields.GRASS else EQUAL_ERROR


def _swept(points: Sequence[Point]) -> dict[str, Reached]:
    return equal_error(points, errors, _compared_at(points[0].case["view"]))


def _shipped_claims(points: Sequence[Point]) -> Iterator[Claim]:
    control = np.concatenate([errors(p) for p in where(points, pruned=shipped.NOTHING)])
    estimand, of_place = "FLIP of shipped references to themselves", partial(_claim, unit="place")
    yield of_place(estimand, within(0, CONTROL), {}, two_sided_mean(control))
    for point in where(points, step=1.0):
        pruned = point.case["pruned"]
        if pruned == shipped.NOTHING:
            continue
        preset = {"preset": point.case["preset"], "pruned": pruned}
        shown = (point.case["preset"], pruned) == ("meadow", shipped.EVERYTHING)
        estimand = "FLIP to the fine reference at shipped settings"
        found, bound = one_sided_mean(errors(point)), at_most(MOST_ERROR)
        yield of_place(estimand, bound, preset, found, headline=shown)
        light = two_sided_mean(shipped.light_ratios(point))
        estimand = "luminance ratio of the land at shipped settings"
        yield of_place(estimand, within(1, 0.01), preset, light)
        off = exactly(float(shipped.bands_off(point)))
        estimand = f"bands of distance whose luminance is off by more than {100 * BAND_MARGIN:g} %"
        yield _claim(estimand, at_most(0), preset, off, unit=UNREPLICATED)


def _cover_claims(points: Sequence[Point]) -> Iterator[Claim]:
    for point in where(points, cover=True):
        case, edges = point.case, cover.LOOKS[point.case["look"]].edges_m
        air = "air of the preset" if case["air"] == "preset" else "clear air"
        for band in range(len(edges) - 1):
            of = {"look": case["look"], "air": air, "τ": f"{case['detail']:g} px"}
            of["distance"] = band_name(edges, band)
            found = {"luminance ratio to the unpruned scene": cover.tone(point, band)}
            if case["air"] == "preset":
                without = cover.tone(point, band, "land")
                found["luminance ratio to the unpruned scene, without airlight"] = without
            found["coverage ratio to the unpruned scene"] = cover.coverage(point, band)
            for estimand, estimate in found.items():
                yield _claim(estimand, within(1, BAND_MARGIN), of, estimate, unit="field")


def _spectrum_claims(points: Sequence[Point]) -> Iterator[Claim]:
    of_direction = partial(claim, unit="direction", source="§2.1, §2.2")
    for point in points:
        of, bound = {"τ": f"{point.case['detail']:g} px"}, at_most(0.1)
        below, above = (spectrum.power(point, "lost", each) for each in (False, True))
        estimand = "share of the removed power below the cut-off 1/(2τ)"
        yield of_direction(estimand, bound, of, two_sided_share(below, below + above))
        left = (spectrum.power(point, each, True) for each in ("pruned", "whole"))
        estimand = "power above the cut-off 1/(2τ), pruned ÷ unpruned"
        yield of_direction(estimand, bound, of, two_sided_paired_ratio(*left))


def _pixel_claims(points: Sequence[Point]) -> Iterator[Claim]:
    for point in points:
        case = point.case
        of = {"species": case["species"], "metric": case["metric"], "τ": f"{case['detail']:g} px"}
        found = two_sided_quantile(pixels.ratios(point), 0.95)
        estimand, bound = "95th percentile of parts ÷ pixels covered", at_most(pixels.MOST)
        yield claim(estimand, bound, of, found, unit="object", source="§4.1")


def _colonnade_claims(points: Sequence[Point]) -> Iterator[Claim]:
    blake, depth, fine_depth = (
        colonnade.columns_of(points, each)
        for each in (colonnade.BLAKE, colonnade.DEPTH, ("depth", 3.0))
    )
    of = {"scene": "colonnade"}
    made = partial(claim, condition=of, unit="render", source="§2.1", alone=EXACT)
    check = partial(made, kind="verification")
    ends = colonnade.image_width(colonnade.places()[-1]) / colonnade.image_width(0.0)
    wide = colonnade.over_middle(blake, "shaft_mpx")
    narrow = colonnade.over_middle(blake, "solid_angle_usr")
    bound = within(round(ends, 4), 0.07)
    yield check("width of the image, outermost ÷ middle", bound, estimate=wide)
    yield check("solid angle, outermost ÷ middle", at_most(1), estimate=narrow)
    side, level = (exactly(colonnade.parts_over_middle(row)) for row in (blake, fine_depth))
    yield made("parts by blake, outermost ÷ middle", at_most(0.9), estimate=side)
    yield check("parts by depth, outermost ÷ middle", equals(1), estimate=level)
    budget = exactly(colonnade.parts_in(blake) / colonnade.parts_in(depth))
    estimand = "parts of all columns, blake at 8 px ÷ depth at 12 px"
    yield check(estimand, within(1, 0.1), estimate=budget)
    for weight, words in (("eye", "solid angle"), ("image", "image area")):
        ratios = colonnade.mean_error(blake, weight) / colonnade.mean_error(depth, weight)
        estimand = f"luminance error weighted by {words}, blake at 8 px ÷ depth at 12 px"
        found = two_sided_mean(ratios)
        yield made(estimand, at_most(1), estimate=found, headline=weight == "eye")


def notes(points: tuple[Point, ...]) -> dict:
    """Return pictures to look at, where the fields of ``fidelity`` were seen."""
    return {NOTE: fields.pictures_of(points)} if where(points, topic="fidelity") else {}


_LEAST = 1e-4
"""The value at which an error of 0 or below is drawn: the axis is logarithmic."""


def _told(drawn: Sequence[Curve]) -> str:
    return "; ".join(f"{c.label}: {', '.join(f'{y:.3f}' for y in c.y)}" for c in drawn)


def _fidelity_plots(record: Record) -> Iterator[Plot]:
    pruned = where(record.points, what="headline", pruned=fields.EVERYTHING)
    kinds: dict[str, Callable[[Point, int], Estimate | None]] = {
        "luminance ratio": luminance_ratio,
        "coverage ratio": coverage_ratio,
        "FLIP in the same places": same_place,
    }
    for name, estimate in kinds.items():
        logarithmic = estimate is same_place
        drawn = []
        for point in pruned:
            bands = fields.judged_bands(point) if len(errors(point)) > 1 else []
            found = {b: e for b in bands if (e := estimate(point, b)) is not None}
            if len(found) > 1:
                middle = [
                    math.sqrt(max(fields.EDGES_M[b], 5.0) * fields.EDGES_M[b + 1]) for b in found
                ]
                least, found_ = _LEAST if logarithmic else -np.inf, list(found.values())
                drawn.append(estimated(point.case["view"], middle, found_, least=least))
        if drawn:
            caption = (
                f"All representations pruned by blake at one pixel: {name} by distance, means over "
                f"fields with 95 % intervals. {_told(drawn)}."
            )
            scales = "log", "log" if logarithmic else "linear"
            axes = "distance (m)", name
            title = f"By distance: {name}"
            yield curves(f"fidelity-{_file(name)}", title, caption, axes, drawn, scales)
    for (view,), swept in grouped(where(record.points, what="sweep"), "view").items():
        reached = "; ".join(
            f"{each.metric}: {f'τ = {each.detail:.2f}' if each.found else 'not in every field'}"
            for each in _swept(swept).values()
        )
        for axis in ("detail threshold τ (px)", "parts displayed"):
            drawn = []
            for (metric,), row in grouped(swept, "metric").items():
                at = {
                    float(p.case["detail"] if "τ" in axis else max(p.values("parts").mean(), 1)): p
                    for p in row
                }
                swept_errors = [one_sided_mean(errors(at[x])) for x in sorted(at)]
                drawn.append(estimated(metric, sorted(at), swept_errors, least=_LEAST))
            caption = (
                f"Mean FLIP of the {view} view, noise extrapolated to zero, all but the ground "
                f"pruned, with one-sided 95 % bounds. It reaches {_compared_at(view)} at {reached}."
            )
            name = f"fidelity-{_file(view)}-{'detail' if 'τ' in axis else 'parts'}"
            title = f"Error against {axis}, {view}"
            yield curves(name, title, caption, (axis, "FLIP"), drawn, ("log", "log"))


def _shipped_plots(record: Record) -> Iterator[Plot]:
    drawn = []
    for (preset,), row in grouped(where(record.points, pruned=shipped.GROUND), "preset").items():
        at = {float(p.values("triangles").mean()): p for p in row}
        found = [one_sided_mean(errors(at[x])) for x in sorted(at)]
        drawn.append(estimated(preset, sorted(at), found, least=_LEAST))
    if drawn:
        x = [value for each in drawn for value in each.x]
        drawn.append(Curve("claimed", [min(x), max(x)], [MOST_ERROR] * 2))
        caption = (
            "FLIP of pictures whose ground alone is pruned, at half, once and twice the shipped τ, "
            "against the triangles in them, mean over places with one-sided 95 % bounds."
        )
        axes = "triangles in the picture", "FLIP"
        yield curves("fidelity-shipped-ground", "Error against triangles", caption, axes, drawn)


def _cover_plots(record: Record) -> Iterator[Plot]:
    for look, outlook in cover.LOOKS.items():
        drawn = []
        for point in where(record.points, look=look, air="clear"):
            middles = [math.sqrt(a * b) for a, b in pairwise(outlook.edges_m)]
            found = [cover.tone(point, band) for band in range(len(middles))]
            bare = "" if point.case["cover"] else ", without cover"
            label = f"{point.case['detail']:g} px{bare}"
            drawn.append(estimated(label, middles, found, least=1e-3))
        if drawn:
            caption = (
                f"Mean luminance of {look} in clear air, pruned ÷ unpruned, by band of distance "
                f"(claimed within {100 * BAND_MARGIN:g} %). {_told(drawn)}."
            )
            axes = "distance (m)", "luminance ratio"
            yield curves(f"cover-{look}", f"Luminance by distance: {look}", caption, axes, drawn)


def _spectrum_plots(record: Record) -> Iterator[Plot]:
    names = {"whole": "unpruned", "pruned": "pruned", "lost": "difference"}
    middles = [math.sqrt(a * b) for a, b in pairwise(spectrum.EDGES)]
    for point in record.points:
        detail, cutoff = point.case["detail"], point.prediction("cutoff")
        drawn = [
            Curve(label, middles, np.maximum(spectrum.octaves(point, name), 1e-12).tolist())
            for name, label in names.items()
        ]
        ends = [min(min(each.y) for each in drawn), max(max(each.y) for each in drawn)]
        drawn.append(Curve("cut-off 1/(2τ)", [cutoff, cutoff], ends))
        caption = (
            "Power of pictures of albedo by octave of frequency, unpruned, pruned at "
            f"τ = {detail:g} px, and their difference."
        )
        axes = "frequency (cycles per pixel)", "power in the octave"
        title = f"Is pruning a low-pass filter? τ = {detail:g} px"
        yield curves(f"spectrum-{detail:g}", title, caption, axes, drawn)


def _pixel_plots(record: Record) -> Iterator[Plot]:
    shares = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
    for (species, detail), row in grouped(record.points, "species", "detail").items():
        drawn = [
            Curve(
                point.case["metric"],
                np.quantile(pixels.ratios(point), [1 - each for each in shares]).tolist(),
                shares,
            )
            for point in row
        ]
        words = "; ".join(f"{each.label} {each.x[3]:.2f} at 5 %" for each in drawn)
        caption = (
            f"Of {species}s at τ = {detail:g} px, drawn alone: the share of them that have more "
            f"parts to a pixel covered. {words}; at most {pixels.MOST:g} is claimed."
        )
        axes = "parts ÷ pixels covered", "share of the objects that have more"
        title = f"Parts to a pixel, {species}s, τ = {detail:g} px"
        yield curves(f"pixels-{species}-{detail:g}", title, caption, axes, drawn)


def _file(name: str) -> str:
    return name.lower().replace(" ", "-")


_SIX_PLACES = (
    *("meadow", "forest", "aerial", "mountain", "badlands"),
    *("crowd", "zoo", "campfire", "playground"),
)

EXPERIMENT = Experiment(
    name="images",
    order=70,
    version=1,
    question="What does pruning do to pictures, by error, brightness, coverage and frequency?",
    topics={
        "fidelity": Topic(
            about="FLIP, luminance and coverage by distance over fields; metrics at equal FLIP",
            cases=fields.cases,
            claims=_fidelity_claims,
            plots=_fidelity_plots,
            accepts_metric=True,
            full={
                "fields": 12,
                "size": "320x180",
                "samples": [32, 128],
                "light_passes": 16,
                "sweep_fields": 4,
                "sweep_size": "160x90",
                "sweep_samples": [32, 128, 32, 128],
                "details": [0.5, 1.0, 2.0, 4.0],
                "grass_details": [0.0625, 0.25, 1.0, 4.0],
                "unseen": True,
            },
            quick={
                "fields": 4,
                "size": "64x36",
                "sweep_fields": 2,
                "sweep_size": "64x36",
                "details": [0.5, 2.0],
                "grass_details": [0.0625, 0.5, 4.0],
                "unseen": False,
            },
            seconds=(2600.0, 230.0),
        ),
        "fidelity_shipped": Topic(
            about="every preset at its shipped settings against a far finer reference",
            cases=shipped.cases,
            claims=_shipped_claims,
            plots=_shipped_plots,
            full={
                "presets": {**dict.fromkeys(_SIX_PLACES, 6), "fly_in": 3},
                "apart": ["mountain", "badlands", "meadow", "aerial"],
                "size": "320x180",
                "unseen": True,
                "samples": [16, 64, 256],
                "light_passes": 32,
                "reference_bytes": 3_000_000_000,
            },
            quick={
                "presets": {"mountain": 2, "meadow": 2, "fly_in": 2},
                "apart": ["mountain"],
                "size": "64x36",
                "unseen": False,
                "samples": [4, 16, 64],
                "light_passes": 16,
                "reference_bytes": 600_000_000,
            },
            seconds=(9500.0, 120.0),
            apart=True,
        ),
        "cover": Topic(
            about="luminance and coverage to 5 km, with and without far cover, against unpruned",
            cases=cover.cases,
            claims=_cover_claims,
            plots=_cover_plots,
            full={
                "fields": {
                    "aerial": 16,
                    **dict.fromkeys(("forest", "far_1_km", "far_2.2_km", "far_5_km"), 32),
                },
                "unseen": True,
            },
            quick={
                "fields": {
                    **dict.fromkeys(("aerial", "forest"), 3),
                    **dict.fromkeys(("far_1_km", "far_2.2_km", "far_5_km"), 4),
                },
                "unseen": False,
            },
            seconds=(1350.0, 200.0),
        ),
        "spectrum": Topic(
            about="power spectra of pruned and unpruned pictures against the cut-off of m",
            cases=spectrum.cases,
            claims=_spectrum_claims,
            plots=_spectrum_plots,
            full={"directions": 8},
            quick={"directions": 3},
            seconds=(25.0, 12.0),
        ),
        "pixels": Topic(
            about="parts of an object against the pixels that it covers alone",
            cases=pixels.cases,
            claims=_pixel_claims,
            plots=_pixel_plots,
            accepts_metric=True,
            full={"objects": 1000},
            quick={"objects": 150},
            seconds=(60.0, 15.0),
        ),
        "colonnade": Topic(
            about="Leonardo's columns: solid angle against image size, true distance against depth",
            cases=colonnade.cases,
            claims=_colonnade_claims,
            plots=colonnade.plots,
            full={"seeds": 8},
            quick={"seeds": 3},
            seconds=(120.0, 60.0),
        ),
    },
    notes=notes,
    rendered=True,
    caveats=(
        "Fields of one preset, with its own trees and people, under three suns and no cloud; sun "
        "and treatment are not crossed.",
        "References are the same scene far finer, not unpruned, except in `cover`: what a preset "
        "leaves out at any detail is in neither picture.",
        "Pictures have 320×180 pixels, sweeps 160×90, quick runs 64×36. FLIP is of one exposure "
        "and 67 pixels per degree. No observer has judged a picture.",
        "Noise is extrapolated to zero by a fit of a + b/√N; the reference against itself says "
        "how far that can be trusted.",
        "A band of distance is judged as a whole: what is too bright here and too dark there "
        "cancels out. Light is seen through the air of both pictures; far away much of it is "
        "airlight, which `cover` takes away.",
        "`spectrum` is of albedo alone in clear air; `pixels` leaves out objects nearer than two "
        "of their bounds; `colonnade` is one row of one kind of column from one place.",
    ),
)
