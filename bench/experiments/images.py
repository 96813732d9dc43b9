"""What does pruning do to pictures, by error, brightness, coverage and frequency? (§2.1, §2.4)

``fidelity`` compares pictures of unseen fields with a much finer reference, and metrics at equal
error (``bar`` does so for presets at their shipped settings); ``cover`` follows luminance and
coverage to 5 km against the unpruned scene, with far cover and without; ``spectrum`` holds powers
of the difference against the cut-off of m; ``pixels`` counts an object's parts against the pixels
that it covers; ``colonnade`` is Leonardo's row of columns.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import pairwise

import numpy as np

from bench.experiment import Experiment, Topic
from bench.images import colonnade, cover, fields, pixels, spectrum
from bench.images.differences import band_name, coverage_ratio, errors, luminance_ratio, same_place
from bench.images.equal_error import EQUAL_ERROR, GRASS_ERROR, Reached, equal_error
from bench.plots import Curve, Panel, Plot, curves, estimated, figure
from bench.records.claims import EXACT, Claim, at_most, claim, equals, within
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

MOST_ERROR = EQUAL_ERROR  # the FLIP to a reference up to which a picture passes

BAND_MARGIN = 0.02
"""How far a band's luminance and coverage may be from the reference's, as a share."""

SHADED = 1 - BAND_MARGIN, 1 + BAND_MARGIN

CONTROL = 0.002  # how far from 0 the fit may find the error of a reference against itself

_claim = partial(claim, source="§2.4")


def _fidelity_claims(points: Sequence[Point]) -> Iterator[Claim]:
    of_field = partial(_claim, unit="field")
    for (view,), chosen in grouped(where(points, what="headline"), "view").items():
        ways = {p.case["pruned"]: p for p in chosen}
        control, bound = errors(ways[fields.NOTHING]), within(0, CONTROL)
        halved = ways.get(fields.COARSER)
        moved = max(0.0, float((errors(halved) - control).mean())) if halved else 0.0
        unknown = abs(float(control.mean())) + moved
        if len(control) > 1:
            found = two_sided_mean(control)
            yield of_field("FLIP of the reference to itself", bound, {"view": view}, found)
        for pruned, words in fields.PRUNED.items():
            if pruned in ways and len(wrong := errors(ways[pruned])) > 1:
                of = {"view": view, "metric": "blake", "τ": "1 px", "pruned": words}
                shown = pruned == fields.EVERYTHING and view != "hazy"
                bound, found = at_most(MOST_ERROR), one_sided_mean(wrong).widened(unknown)
                yield of_field("FLIP to the reference", bound, of, found, headline=shown)
        point = ways[fields.EVERYTHING]
        for band in fields.judged_bands(point):
            of = {"view": view, "distance": band_name(fields.EDGES_M, band)}
            for estimand, ratio in (("luminance", luminance_ratio), ("coverage", coverage_ratio)):
                step = abs(ratio(halved, band).value - 1) if halved else 0.0
                found = ratio(point, band).widened(step)
                yield of_field(
                    f"{estimand} ratio to the reference", within(1, BAND_MARGIN), of, found
                )
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
        yield made(estimand, at_most(1), estimate=found, headline=True)


def notes(points: tuple[Point, ...]) -> dict:
    """Return pictures to look at, where the fields of ``fidelity`` were seen."""
    return {NOTE: fields.pictures_of(points)} if where(points, topic="fidelity") else {}


_LEAST = 1e-4  # the value at which an error of 0 or below is drawn: the axis is logarithmic


def _fidelity_plots(record: Record) -> Iterator[Plot]:
    if headline := where(record.points, what="headline", pruned=fields.EVERYTHING):
        yield from _by_distance(headline)
    if sweep := where(record.points, what="sweep"):
        yield _metrics_plot(sweep)


def _by_distance(points: Sequence[Point]) -> Iterator[Plot]:
    kinds: dict[str, Callable[[Point, int], Estimate | None]] = {
        "luminance ÷ the reference's": luminance_ratio,
        "coverage ÷ the reference's": coverage_ratio,
        "FLIP in the same places": same_place,
    }
    panels, ratios, worst = [], [], 0.0
    for name, estimate in kinds.items():
        drawn = []
        for point in points:
            bands = fields.judged_bands(point) if len(errors(point)) > 1 else []
            found = {b: e for b in bands if (e := estimate(point, b)) is not None}
            if len(found) > 1:
                x = [math.sqrt(max(fields.EDGES_M[b], 5.0) * fields.EDGES_M[b + 1]) for b in found]
                least = _LEAST if estimate is same_place else -np.inf
                drawn.append(estimated(point.case["view"], x, [*found.values()], least=least))
                if estimate is same_place:
                    worst = max(worst, *(e.value for e in found.values()))
                else:
                    ratios += [abs(e.value - 1) for e in found.values()]
        same = estimate is same_place
        axis, scale = ("distance (m)", name), ("log", "log" if same else "linear")
        panels.append(Panel("", axis, drawn, scale, between=None if same else SHADED))
    if ratios:
        inside = sum(r <= BAND_MARGIN for r in ratios)
        title = (
            f"{inside} of {len(ratios)} means of luminance and coverage by distance stay within "
            f"{100 * BAND_MARGIN:g} %; in the same places pictures differ by up to FLIP {worst:.2g}"
        )
        caption = (
            "All representations pruned by blake at one pixel, against a finer reference; means "
            "over fields with 95 % intervals, FLIP without noise. Shaded: claimed."
        )
        yield figure("by-distance", title, caption, panels)


def _metrics_plot(points: Sequence[Point]) -> Plot:
    panels, told = [], []
    for (view,), swept in grouped(points, "view").items():
        drawn = []
        for (metric,), row in grouped(swept, "metric").items():
            at = {max(float(p.values("parts").mean()), 1.0): p for p in row}
            found = [one_sided_mean(errors(at[x])) for x in sorted(at)]
            drawn.append(estimated(metric, sorted(at), found, least=_LEAST))
        panels.append(Panel(view, ("parts displayed", "FLIP, one-sided 95 % bounds"), drawn))
        reached = [each for each in _swept(swept).values() if each.found]
        if reached and reached[0].metric == "blake":
            told += [
                f"{reached[0].parts_over(each):.2f} times those of {each.metric} in {view}"
                for each in reached[1:]
            ]
    title = "Error against parts displayed, by metric"
    if told:
        title = f"Parts of blake at equal error: {'; '.join(told)}"
    caption = (
        "Mean FLIP over fields, noise extrapolated to zero, all but the ground pruned. Compared at "
        f"FLIP {EQUAL_ERROR:g}, over nothing but grass at {GRASS_ERROR:g}."
    )
    return figure("metrics", title, caption, panels)


def _cover_plots(record: Record) -> Iterator[Plot]:
    clear = where(record.points, air="clear")
    looks = {
        look: max(p.case["detail"] for p in row) for (look,), row in grouped(clear, "look").items()
    }
    panels, off = [], {}
    for bare, words in ((False, "With far cover"), (True, "Without")):
        drawn = []
        for look, detail in looks.items():
            edges = cover.LOOKS[look].edges_m
            middles = [math.sqrt(a * b) for a, b in pairwise(edges)]
            for point in where(clear, look=look, detail=detail, cover=not bare):
                found = [cover.tone(point, band) for band in range(len(edges) - 1)]
                label = f"{look.replace('_', ' ')}, τ = {detail:g} px"
                drawn.append(estimated(label, middles, found, least=1e-3))
        if drawn:
            off[bare] = max(abs(y - 1) for each in drawn for y in each.y)
            axis = "distance (m)", "luminance ÷ unpruned"
            panels.append(Panel(words, axis, drawn, ("log", "linear"), between=SHADED))
    title = "Luminance by distance, against the unpruned scene"
    if len(off) == 2:
        title = (
            f"Far land is off by up to {100 * off[True]:.0f} % without the cover that stands for "
            f"what is left out, with it by {100 * off[False]:.0f} %"
        )
    caption = "Clear air; means over fields with 95 % intervals. Shaded: claimed."
    if panels:
        yield figure("cover", title, caption, panels)


def _spectrum_plots(record: Record) -> Iterator[Plot]:
    middles, drawn, told = [math.sqrt(a * b) for a, b in pairwise(spectrum.EDGES)], [], []
    for point in sorted(record.points, key=lambda p: p.case["detail"]):
        label, cutoff = f"τ = {point.case['detail']:g} px", point.prediction("cutoff")
        lost, whole = (np.maximum(spectrum.octaves(point, n), 1e-12) for n in ("lost", "whole"))
        drawn.append(Curve(label, [x / cutoff for x in middles], (lost / whole).tolist()))
        below, above = (spectrum.power(point, "lost", each).sum() for each in (False, True))
        told.append(f"{100 * below / (below + above):.0f} % at {label}")
    title = f"No low-pass filter: of the power lost, {told[0]} lies below the cut-off"
    caption = (
        "Power of the difference of albedo ÷ power of the unpruned picture, by octave. A low-pass "
        "filter would leave 0 below 1 and take 1 above. Below the cut-off 1/(2τ): "
        f"{'; '.join(told)}."
    )
    axis = "frequency ÷ cut-off 1/(2τ)", "power lost ÷ power unpruned"
    yield curves("spectrum", title, caption, axis, drawn)


def _pixel_plots(record: Record) -> Iterator[Plot]:
    shares = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
    panels: list[Panel] = []
    most: dict[tuple[str, float, str], float] = {}
    for (species, detail), row in grouped(record.points, "species", "detail").items():
        drawn = [
            Curve(
                point.case["metric"],
                np.quantile(pixels.ratios(point), [1 - each for each in shares]).tolist(),
                shares,
            )
            for point in row
        ]
        most |= {(species, detail, each.label): each.x[3] for each in drawn}
        axis = "parts ÷ pixels covered", "share of the objects that have more"
        panels.append(Panel(f"{species}, τ = {detail:g} px", axis, drawn))
    title = (
        f"One object in twenty has more than {min(most.values()):.2g} to {max(most.values()):.2g} "
        f"parts to a pixel; {pixels.MOST:g} is claimed"
    )
    caption = "Objects drawn alone, at the distances of a field."
    yield figure("pixels", title, caption, panels)


EXPERIMENT = Experiment(
    name="images",
    order=70,
    version=2,
    question="What does pruning do to pictures, by error, brightness, coverage and frequency?",
    topics={
        "fidelity": Topic(
            about="FLIP, luminance and coverage by distance over fields; metrics at equal FLIP",
            cases=fields.cases,
            claims=_fidelity_claims,
            plots=_fidelity_plots,
            accepts=("metric", "preset"),
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
                "details": [0.5, 4.0],
                "grass_details": [0.0625, 0.5, 4.0],
                "unseen": False,
            },
            seconds=(4000.0, 300.0),
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
            accepts=("metric",),
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
        "Fields of one preset, without grass, with its own trees and people, under three suns and "
        "no cloud; or of a preset of your own, under its own sun.",
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
