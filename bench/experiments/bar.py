"""Do the presets as shipped meet the bar? (docs/method.md, "The bar")

``stills`` judges luminance and coverage by distance, contrast by octave and distance, and FLIP
between its floor and its ceiling; ``walks`` judges stills and walks by ColorVideoVDP, whose
environment is made on request.
"""

import gc
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from bench.experiment import Case, Experiment, Table, Topic
from bench.experiments.images import BAND_MARGIN, MOST_ERROR, SHADED
from bench.images import as_shipped
from bench.images.differences import errors
from bench.methods.environments import VIDEO
from bench.methods.video import just_objectionable_differences
from bench.plots import Panel, Plot, estimated, figure
from bench.records.claims import Claim, at_least, at_most, claim, within
from bench.records.records import Column, Point, Record, columns, grouped
from bench.statistics.estimates import (
    Estimate,
    exactly,
    one_sided_mean,
    two_sided_mean,
    two_sided_paired_ratio,
    two_sided_ratio_of_means,
)
from lod.arrays import Reals
from lod.errors import InputError
from scenes.presets.load import load_preset
from scenes.render.budget import reference_preset
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.render import build_frame, trace
from scenes.render.variants import choose
from scenes.scene import Scene

CONTRAST_MARGIN = 0.05
MOST_SHARE, MOST_EXCESS = 0.2, 0.02
"""The most that FLIP is from its floor, as a share of the way to its ceiling, and as itself."""

LEAST_JOD = {"still": 9.8, "walk": 9.5}
LEAST_SHARE = 0.01  # the share of the rays that meet land from which on a band is judged

OF = {"land": "land", "things": "what stands on it"}
IN_BANDS = "luminance", "coverage"

_of_place = partial(claim, unit="place", source="docs/method.md, The bar")


def _sums(points: Sequence[Point], quantity: str, of: str, picture: str) -> np.ndarray:
    """Sum light or rays over the suns of each place, (bands, places).

    Every sun counts alike: light is in units of that of the reference's land under the same sun.
    """
    total = np.zeros(())
    for point in points:

        def rows(of: str, picture: str, point: Point = point) -> np.ndarray:
            bands = range(as_shipped.BANDS)
            keys = {"picture": picture, "of": of}
            return np.array([point.values(quantity, **keys, band=k) for k in bands])

        unit = rows("land", "reference").sum(axis=0) if quantity == "light" else 1.0
        total = total + rows(of, picture) / unit
    return total


def _ratios(points: Sequence[Point], of: str, picture: str) -> dict[int, tuple[Estimate, Estimate]]:
    """Estimate luminance and coverage, a picture ÷ the reference, of bands that two places see."""
    lit, whole = (_sums(points, "light", of, each) for each in (picture, "reference"))
    rays, all_rays = (_sums(points, "rays", of, each) for each in (picture, "reference"))
    return {
        k: (
            two_sided_ratio_of_means(lit[k], rays[k], whole[k], all_rays[k]),
            two_sided_paired_ratio(rays[k], all_rays[k]),
        )
        for k in range(as_shipped.BANDS)
        if min((rays[k] > 0).sum(), (all_rays[k] > 0).sum()) > 1
    }


def _in_bands(points: Sequence[Point]) -> Iterator[tuple[str, str, int, Estimate]]:
    """Estimate luminance and coverage of every judged band, as shipped ÷ reference.

    Gives the estimand, of what it is, the band and the estimate, which is as much wider as the
    reference moved when its detail was last halved.
    """
    land, halved = _sums(points, "rays", "land", "reference").sum(), _having(points, "coarser")
    for of in OF:
        rays = _sums(points, "rays", of, "reference")
        moved = _ratios(halved, of, "coarser") if halved else {}
        for k, found in _ratios(points, of, "tested").items():
            if rays[k].sum() >= LEAST_SHARE * land:
                steps = moved.get(k, (exactly(1.0),) * 2)
                for estimand, each, step in zip(IN_BANDS, found, steps, strict=True):
                    yield estimand, of, k, each.widened(abs(step.value - 1))


def _contrast(points: Sequence[Point], picture: str, octave: int, band: int) -> Estimate | None:
    """Estimate contrast, a picture ÷ the reference; None where fewer than two places have any."""
    one, other = (
        sum(
            (p.values("power", picture=each, octave=octave, band=band) for p in points),
            np.zeros(()),
        )
        for each in (picture, "reference")
    )
    if not (other.sum() > 0 and (other != 0).sum() > 1):
        return None
    found = two_sided_paired_ratio(one, other)
    value, low, high = np.sqrt(np.maximum((found.value, found.low, found.high), 0.0))
    return replace(found, value=value, low=low, high=high)


def _contrasts(points: Sequence[Point]) -> Iterator[tuple[int, int, Estimate]]:
    """Estimate contrast as shipped ÷ reference, of every octave and judged band, as in bands."""
    rays, halved = (
        _sums(points, "rays", "land", "reference").sum(axis=1),
        _having(points, "coarser"),
    )
    for octave in as_shipped.OCTAVES_PX:
        for k in np.flatnonzero(rays >= LEAST_SHARE * rays.sum()).tolist():
            if (found := _contrast(points, "tested", octave, k)) is not None:
                step = _contrast(halved, "coarser", octave, k) if halved else None
                yield octave, k, found.widened(abs(step.value - 1) if step else 0.0)


def _error(points: Sequence[Point], picture: str) -> Reals:
    """Return FLIP without noise of every place, the mean over its suns, (places,)."""
    return np.mean([errors(point, picture=picture) for point in points], axis=0)


def _having(points: Sequence[Point], picture: str) -> list[Point]:
    """Return the points that have seen a picture: not all have a ceiling or a coarser reference."""
    return [p for p in points if any(c.keys.get("picture") == picture for c in p.samples)]


def _moved(points: Sequence[Point]) -> float:
    """Return the FLIP, beyond its floor, by which halving its detail last moved the reference."""
    if not (halved := _having(points, "coarser")):
        return 0.0
    return max(0.0, float((_error(halved, "coarser") - _error(halved, "floor")).mean()))


def _share(points: Sequence[Point]) -> Estimate:
    """Estimate how far FLIP is on the way from its floor to its ceiling."""
    error, floor, ceiling = (_error(points, each) for each in ("tested", "floor", "ceiling"))
    found = two_sided_paired_ratio(error - floor, ceiling - floor)
    return found.widened(_moved(points) / float((ceiling - floor).mean()))


def _still_claims(points: Sequence[Point]) -> Iterator[Claim]:
    for (preset,), mine in grouped(points, "preset").items():
        named = {"preset": preset}
        for estimand, of, band, found in _in_bands(mine):
            where = {**named, "what": OF[of], "band": band + 1}
            yield _of_place(
                f"{estimand} ratio to the reference", within(1, BAND_MARGIN), where, found
            )
        for octave, band, found in _contrasts(mine):
            where = {**named, "octave": f"{octave} to {2 * octave} px", "band": band + 1}
            bound = within(1, CONTRAST_MARGIN)
            yield _of_place("contrast ratio to the reference", bound, where, found)
        error, moved = _error(mine, "tested"), _moved(mine)
        excess = two_sided_mean(error - _error(mine, "floor")).widened(moved)
        yield _of_place("FLIP less its floor", at_most(MOST_EXCESS), named, excess)
        if _having(mine, "ceiling"):
            estimand, shown = "(FLIP − floor) ÷ (ceiling − floor)", preset == "meadow"
            yield _of_place(estimand, at_most(MOST_SHARE), named, _share(mine), headline=shown)
        old = {**named, "pruned": "everything"}
        estimand = "FLIP to the fine reference at shipped settings"
        found = one_sided_mean(error).widened(moved)
        yield _of_place(estimand, at_most(MOST_ERROR), old, found, source="§2.4")


def _walk_claims(points: Sequence[Point]) -> Iterator[Claim]:
    for point in points:
        for what, least in LEAST_JOD.items():
            jod = two_sided_mean(point.values("jod_ppm", what=what, picture="tested") / 1e6)
            where = {"preset": point.case["preset"], "what": what}
            yield _of_place("ColorVideoVDP [JOD]", at_least(least), where, jod)


def _still_tables(record: Record) -> Iterator[tuple[str, Table]]:
    three = (*IN_BANDS, "contrast")
    heads = ("preset", "reference, px", "moved", *three, "FLIP", "floor", "ceiling", "share")
    rows = []
    for (preset,), mine in grouped(record.points, "preset").items():
        judged = [each for each in _still_claims(mine) if each.unit == "place"]
        counts = [
            Counter(each.verdict for each in judged if each.estimand.startswith(estimand))
            for estimand in three
        ]
        fine = np.concatenate([p.values("reference_ppm") for p in mine]) / 1e6
        told = [f"{c['holds']} of {sum(c.values())}, {c['refuted']} refuted" for c in counts]
        ends = ("tested", "floor", "ceiling")[: 3 if _having(mine, "ceiling") else 2]
        flip = [f"{_error(mine, each).mean():.4f}" for each in ends]
        share = [f"{_share(mine):.2f}"] if _having(mine, "ceiling") else ["–", "–"]
        seen = f"{fine.min():.3g} to {fine.max():.3g}", f"{_moved(mine):.4f}"
        rows.append((preset, *seen, *told, *flip, *share))
    yield "Every preset against the bar", (heads, rows)


def _still_plots(record: Record) -> Iterator[Plot]:
    groups = {name: row for (name,), row in grouped(record.points, "preset").items()}
    names = sorted(groups, key=lambda name: float(_error(groups[name], "tested").mean()))
    drawn = []
    for picture, label in (("floor", "floor"), ("tested", "as shipped"), ("ceiling", "ceiling")):
        mine = [n for n in names if picture != "ceiling" or _having(groups[n], "ceiling")]
        found = [two_sided_mean(_error(groups[name], picture)) for name in mine]
        drawn.append(estimated(label, [float(names.index(n)) for n in mine], found, least=1e-4))
    axis = "preset", "FLIP without noise"
    panels = [Panel("Between floor and ceiling", axis, drawn, ("linear", "log"), "points", names)]
    shares = [_share(row) for row in groups.values() if _having(row, "ceiling")]
    title = (
        f"{sum(each.high <= MOST_SHARE for each in shares)} of the {len(shares)} presets as "
        f"shipped that have a ceiling are within {100 * MOST_SHARE:g} % of the way to it"
    )
    caption = (
        "Means over places with 95 % intervals. The floor is the reference with other samples, the "
        "ceiling the preset with its objects redrawn."
    )
    yield figure("presets", title, caption, panels)
    panels, off = [], 0.0
    for estimand in IN_BANDS:
        for of, words in OF.items():
            drawn = []
            for name, row in groups.items():
                here = {k: e for what, o, k, e in _in_bands(row) if (what, o) == (estimand, of)}
                if here:
                    x = [float(k + 1) for k in here]
                    drawn.append(estimated(name, x, [*here.values()]))
                    off = max(off, *(abs(e.value - 1) for e in here.values()))
            axis = "band of distance, near to far", f"{estimand} ÷ the reference's"
            panels.append(Panel(words, axis, drawn, ("linear", "linear"), between=SHADED))
    title = f"By distance, luminance and coverage are off by up to {100 * off:.0f} %"
    caption = (
        "Means over places with 95 % intervals, by bands that are even in the logarithm, from "
        "twice the height of the eye to where air or ground ends. Shaded: "
        f"± {100 * BAND_MARGIN:g} %."
    )
    yield figure("bands", title, caption, panels)


# A still and a walk by ColorVideoVDP.

SPEED = "camera.speed=1.4"  # as fast as one walks [m/s]


def _walk_cases(
    presets: Sequence[str],
    walks: int,
    size: str | None,
    unseen: bool,
    frames: int,
    samples: int,
    still_samples: int,
    reference_bytes: int,
) -> list[Case]:
    """Return the walks of every preset. Raises InputError where the judge has no environment."""
    if VIDEO.python() is None:
        cure = f"`lodbench environments {VIDEO.name}` makes it, or run `stills` alone"
        raise InputError(VIDEO.name, "no environment", "ColorVideoVDP runs in it", cure)
    rest = frames, samples, still_samples, choose(), reference_bytes
    made: list[Case] = []
    for name in presets:
        every = as_shipped.places(name, walks, unseen, size)
        suns = len(every) // walks
        chosen = (every[number * suns + number % suns] for number in range(walks))
        made += [partial(measure_walk, place, *rest) for place in chosen]
    return made


def measure_walk(
    place: as_shipped.Place,
    frames: int,
    samples: int,
    still_samples: int,
    variant: str,
    reference_bytes: int,
    seed: int,
) -> Point:
    """Walk on from one place, and judge its first frame and the walk, in millionths of a JOD."""
    preset = load_preset(place.preset, (*place.settings, SPEED))
    scene, numbers = Scene(preset), range(1, frames + 1)
    fine = scene.with_preset(reference_preset(preset, (1, frames), reference_bytes))
    stills: dict[str, np.ndarray] = {}
    shown: dict[str, list[np.ndarray]] = {"tested": [], "reference": [], "floor": []}
    exposure = 0.0
    for number in numbers:
        for which, mine, seeds in (
            ("reference", fine, {"reference": seed, "floor": seed + 1000}),
            ("tested", scene, {"tested": seed}),
        ):
            gc.collect()
            frame_input = (as_shipped.shipped if which == "tested" else Scene.input)(
                mine, number, variant
            )
            stage = build_frame(frame_input)
            for name, own in seeds.items():
                quality = replace(frame_input.quality, spp=samples, seed=own)
                light = trace(stage, quality, number).rgb.astype(np.float64)
                exposure = exposure or auto_exposure(light)
                shown[name].append(to_srgb(light, exposure).astype("f4"))
                if number == 1:
                    clear = trace(stage, replace(quality, spp=still_samples), number).rgb
                    stills[name] = to_srgb(clear.astype(np.float64), exposure).astype("f4")[None]
    judged = {"still": stills, "walk": {name: np.stack(row) for name, row in shown.items()}}
    found = {"place": [place.number], "world_seed": [preset.seed]}
    samples_of = [*columns(found)]
    for what, each in judged.items():
        reference = each.pop("reference")
        jod = just_objectionable_differences(each, reference, float(preset.camera.fps))
        samples_of += [
            Column("jod_ppm", [round(1e6 * value)], {"what": what, "picture": name})
            for name, (value,) in jod.items()
        ]
    case = {"topic": "walks", "preset": place.preset}
    return Point(case, samples=tuple(samples_of))


_PRESETS = (
    *("meadow", "forest", "mountain", "aerial", "badlands"),
    *("crowd", "zoo", "campfire", "playground", "fly_in"),
)

EXPERIMENT = Experiment(
    name="bar",
    order=75,
    version=1,
    question="Do the presets as shipped meet the bar?",
    topics={
        "stills": Topic(
            about="presets as shipped: luminance, coverage and contrast by distance, and FLIP",
            cases=as_shipped.cases,
            claims=_still_claims,
            plots=_still_plots,
            tables=_still_tables,
            full={
                "presets": dict.fromkeys(_PRESETS, 8),
                "size": None,
                "unseen": True,
                "samples": [32, 128],
                "light_passes": 32,
                "reference_bytes": 8_000_000_000,
            },
            quick={
                "presets": {"meadow": 2, "fly_in": 2},
                "size": "64x36",
                "unseen": False,
                "samples": [8, 32],
                "light_passes": 8,
                "reference_bytes": 700_000_000,
            },
            seconds=(90_000.0, 200.0),
            apart=True,
        ),
        "walks": Topic(
            about="a still and a walk of four presets as shipped, by ColorVideoVDP",
            cases=_walk_cases,
            claims=_walk_claims,
            full={
                "presets": ["meadow", "forest", "crowd", "mountain"],
                "walks": 3,
                "size": None,
                "unseen": True,
                "frames": 48,
                "samples": 32,
                "still_samples": 256,
                "reference_bytes": 6_000_000_000,
            },
            quick={
                "presets": ["crowd"],
                "walks": 2,
                "size": "64x36",
                "unseen": False,
                "frames": 3,
                "samples": 8,
                "still_samples": 16,
                "reference_bytes": 1_200_000_000,
            },
            seconds=(60_000.0, 120.0),
            apart=True,
        ),
    },
    rendered=True,
    caveats=(
        "The reference is as fine as its memory allows, which points note: it is not unpruned. "
        "Intervals are as much wider as it moved when its detail was last halved.",
        "Several hundred claims are judged, each by an interval of its own: some are refuted, and "
        "some hold, by chance.",
        "The ceiling has the detail of the preset, so what is off there is in the ceiling, too.",
        "The sums over bands are of rays with the same samples in both pictures; contrast counts "
        "pixels by the distance of one sample of the reference.",
    ),
)
