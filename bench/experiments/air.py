"""Is haze as rendered what it should be? Targets, the scattering medium and spectral light (§2.1).

Black and grey targets at 20 distances, in both frame drivers and in the medium, give β and V
(``bench.haze_targets``). In bands of distance of `meadow` at V = 5 km the closed form is compared
with the medium that scatters light, and RGB with spectral haze by CIEDE2000. All samples are
integers: radiance in 10⁻⁹, ΔE in 10⁻³.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial

import numpy as np

from bench.experiment import Case, Experiment, Topic
from bench.haze_targets import DISTANCES, extinction_seen, look_at, order, visibility_seen
from bench.plots import Curve, Plot, curves
from bench.records.claims import Claim, Kind, at_most, claim, within
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point, Record, columns, grouped, where
from bench.statistics.estimates import Estimate, two_sided_mean
from lod.air import Air, rgb_extinction
from scenes.frame.frame_input import FrameInput, Quality
from scenes.frame.layers import SKY_Z
from scenes.presets.load import load_preset
from scenes.render.pictures import auto_exposure
from scenes.render.render import render_frame
from scenes.render.variants import JIT_VARIANT, SCALAR_VARIANT, choose, works
from scenes.scene import Scene
from scenes.sticks.prototype import LUMINANCE

VISIBILITIES_M = (1e3, 5e3, 20e3)
MEADOW = (
    *("air.visibility=5km", "render.size=96x54", "render.max_depth=16"),
    "species.sward.density=0",
)
MEADOW_SPP = {"analytic": 32, "medium": 384, "spectral": 64}
"""Samples of a pixel of the meadow in every kind of haze."""

BAND_EDGES_M = (0.0, 50.0, 100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0, 6400.0)
SKY = 1e10
"""The lower edge [m] of the band of rays that meet nothing."""


def cases(target_spp: Mapping[str, int], seeds: int) -> list[Case]:
    """Return the targets by every way that works here and every visibility, then the meadow."""
    ways = {"scalar": SCALAR_VARIANT, "jit": JIT_VARIANT, "medium": choose()}
    working = {name: variant for name, variant in ways.items() if works(variant) is True}
    return [
        *(
            partial(measure_targets, way, visibility, variant, target_spp[way])
            for way, variant in working.items()
            for visibility in VISIBILITIES_M
        ),
        *(partial(_measure_meadow, number) for number in range(seeds)),
    ]


def _measure_meadow(number: int, seed: int) -> list[Point]:
    frame, scene = _meadow()
    return [
        Point(
            {"topic": "air", "what": "bands", "from": low},
            samples=columns({k: [v] for k, v in values.items()}),
            scene=scene,
        )
        for low, values in _by_distance(frame, seed + number).items()
    ]


def measure_targets(way: str, visibility: float, variant: str, spp: int, seed: int) -> Point:
    """Measure the radiance of every target in haze, and of the endless path beside it.

    They are rendered by one frame driver, or in the medium, which is the way.
    """
    haze = "medium" if way == "medium" else "analytic"
    target, beyond = look_at(visibility, Quality(variant, spp, seed, 4, haze))
    step, albedo = order(seed)
    radiance = (
        Column(name, [round(1e9 * float(v)) for v in rgb[:, number]], {"band": band})
        for number, band in enumerate("rgb")
        for name, rgb in (("target", target), ("beyond", beyond))
    )
    named = {"topic": "air", "what": "targets", "way": way, "visibility": visibility}
    places = columns({"step": step.tolist(), "grey": albedo.tolist()})
    return Point(named, samples=(*places, *radiance))


@lru_cache(maxsize=1)
def _meadow() -> tuple[FrameInput, str]:
    preset = load_preset("meadow", list(MEADOW))
    return Scene(preset).input(1, choose()), scene_digest([preset.model_dump(mode="json")])


def _by_distance(frame: FrameInput, seed: int) -> dict[float, dict[str, int]]:
    seen = {}
    for kind, spp in MEADOW_SPP.items():
        variant = choose("auto", kind == "spectral")
        haze = "analytic" if kind == "spectral" else kind
        quality = replace(frame.quality, variant=variant, haze=haze, spp=spp, seed=seed)
        seen[kind] = render_frame(replace(frame, quality=quality), 1)
    distance, difference = seen["analytic"].Z, delta_e(seen["analytic"].rgb, seen["spectral"].rgb)
    edges, made = (*BAND_EDGES_M, float(SKY_Z)), {}
    for low, high in zip(edges, (*edges[1:], np.inf), strict=True):
        mine = (distance >= low) & (distance < high)
        if not mine.any():
            continue
        values = {k: float((layers.rgb[mine] @ LUMINANCE).mean()) for k, layers in seen.items()}
        made[SKY if low == float(SKY_Z) else low] = {
            "pixels": int(mine.sum()),
            **{k: round(1e9 * value) for k, value in values.items()},
            "delta_e": round(1e3 * float(np.median(difference[mine]))),
        }
    return made


def delta_e(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return CIEDE2000 of two pictures, each at the exposure that suits it, (h, w)."""
    from colour import RGB_to_XYZ, XYZ_to_Lab, delta_E

    labs = []
    for rgb in (one, other):
        light = np.maximum(rgb.astype(np.float64), 0.0) * auto_exposure(rgb)
        labs.append(XYZ_to_Lab(RGB_to_XYZ(light, "ITU-R BT.709")))
    return np.asarray(delta_E(labs[0], labs[1], method="CIE 2000"))


# Claims, from raw radiances alone.

FEWEST = 30  # the fewest pixels with which a band is judged

TOLERANCE = {"scalar": 0.01, "jit": 0.01, "medium": 0.03}
_claim = partial(claim, source="§2.1")


def claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Return every claim that these points decide."""
    targets = where(points, what="targets")
    for point in targets:
        yield from _visibility(point)
    for (way,), chosen in grouped(targets, "way").items():  # β over all visibilities and targets
        shares = np.concatenate(
            [found(p)[0] / rgb_extinction(Air(p.case["visibility"])) for p in chosen]
        )
        for number, band in enumerate(("red", "green", "blue")):
            share = two_sided_mean(shares[:, number])
            yield _of_way(way, "β ÷ true β", {"band": band}, share, "fit")
    for point in where(points, what="bands"):
        if point.column("pixels")[0] >= FEWEST:
            yield from _of_band(point)


def found(point: Point) -> tuple[np.ndarray, np.ndarray]:
    """Fit β of each band and its standard error from black and from grey targets, (2, bands)."""
    target, beyond = (
        np.stack([point.values(name, band=band) for band in "rgb"], axis=1)
        for name in ("target", "beyond")
    )
    distance = point.case["visibility"] * point.values("step") / DISTANCES
    fit = extinction_seen(target, beyond, distance, point.values("grey") == 1)
    return fit[:2], fit[2:]


def _of_way(
    way: str, estimand: str, condition: dict[str, str], share: Estimate, unit: str
) -> Claim:
    """Claim a ratio of one way to render haze; the closed form can only give back its own β."""
    kind: Kind = "measurement" if way == "medium" else "verification"
    bound, of = within(1, TOLERANCE[way]), {"haze": way, **condition}
    return _claim(estimand, bound, of, share, unit=unit, kind=kind)


def _visibility(point: Point) -> Iterator[Claim]:
    way, true = point.case["way"], point.case["visibility"]
    for name, beta, error in zip(("black", "grey"), *found(point), strict=True):
        seen = visibility_seen(beta, error)
        share = Estimate(seen.value / true, seen.low / true, seen.high / true, 0.0, 1.0, len(beta))
        condition = {"targets": f"{name} targets", "V": f"{true / 1000:g} km"}
        yield _of_way(way, "V at 550 nm ÷ true V", condition, share, "target")


def _of_band(point: Point) -> Iterator[Claim]:
    at, of_seed = {"preset": "meadow", "distance": label(point)}, partial(_claim, unit="seed")
    if point.case["from"] != SKY:
        share = two_sided_mean(point.values("analytic") / point.values("medium"))
        of, estimand = {"haze": "analytic airlight", **at}, "mean luminance ÷ scattering medium's"
        yield of_seed(estimand, within(1, 0.03), of, share)
    share = two_sided_mean(point.values("delta_e") / 1000)
    yield of_seed("median CIEDE2000 of RGB haze to spectral haze", at_most(2), at, share)


def label(point: Point) -> str:
    """Return the name of the band, in words."""
    return "sky" if point.case["from"] == SKY else f"from {point.case['from']:g} m"


# Plots.

_DRAWN_M = 5e3  # the visibility of the targets that are drawn [m]


def plots(record: Record) -> tuple[Plot, ...]:
    """Draw the contrast of black targets in green, and the brightness of the meadow."""
    return _contrast(record), _brightness(record)


def _contrast(record: Record) -> Plot:
    drawn = []
    for point in where(record.points, what="targets", visibility=_DRAWN_M):
        black = point.values("grey") == 0
        step = point.values("step")[black]
        rows = np.argsort(step)
        target, beyond = (point.values(k, band="g")[black] for k in ("target", "beyond"))
        contrast = np.abs(target / beyond - 1)[rows]
        x = step[rows] / DISTANCES
        law = np.exp(-rgb_extinction(Air(_DRAWN_M))[1] * x * _DRAWN_M)
        line = x.tolist(), law.tolist()
        drawn.append(Curve(point.case["way"], x.tolist(), contrast.tolist(), line=line))
    words = "; ".join(f"{c.label}: {c.y[-1]:.4f} at V" for c in drawn)
    caption = (
        "Contrast in green of black targets against the endless path beside them, V = 5 km. "
        f"Dashed: exp(−βd). {words}."
    )
    axis = "distance ÷ V", "contrast"
    return curves("contrast", "Contrast in haze", caption, axis, drawn, ("linear", "log"))


def _brightness(record: Record) -> Plot:
    rows = [p for p in where(record.points, what="bands") if p.case["from"] != SKY]
    x = [max(p.case["from"], 25.0) for p in rows]
    shares = [float(np.mean(p.values("analytic") / p.values("medium"))) for p in rows]
    drawn = [Curve("analytic", x, shares, line=(x, [1.0] * len(x)))]
    caption = (
        "Mean luminance of meadow at V = 5 km by distance, over that of the medium which scatters "
        f"light, from {min(shares):.3f} to {max(shares):.3f}; dashed: as bright. The closed form "
        "takes its airlight from the sky model's horizon, which a thin layer of air under that "
        "sky does not reach."
    )
    axis = "distance of the band's near end (m)", "luminance ÷ the medium's"
    return curves("medium", "Closed form and medium", caption, axis, drawn)


EXPERIMENT = Experiment(
    name="air",
    question=(
        "Is the haze in the pictures what theory, a scattering medium and light of sixteen bands "
        "make of it?"
    ),
    version=2,
    topics={
        "air": Topic(
            about="haze as rendered: targets, the medium that scatters light, and spectral light",
            cases=cases,
            claims=claims,
            plots=plots,
            full={"target_spp": {"scalar": 512, "jit": 512, "medium": 2048}, "seeds": 8},
            quick={"target_spp": {"scalar": 256, "jit": 256, "medium": 512}, "seeds": 4},
            seconds=(145.0, 80.0),
        )
    },
    notes=lambda points: {"meadow_spp": MEADOW_SPP},
    caveats=(
        "The airlight of the horizon's sky leaves out which way the sun stands to the air, that "
        "its glow varies with height, that it lies in the shade of what stands in it, and that it "
        "dims the light on its way to the ground.",
        "The medium is a layer 10 m higher than the scene, under a sky that holds a whole "
        "atmosphere already; its phase function is one of clean continental air.",
        "RGB and spectral pictures also differ in the coefficients of the sky's model: the row of "
        "the sky shows by how much.",
    ),
    rendered=True,
    order=60,
)
