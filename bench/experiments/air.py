"""Is haze as rendered what it should be? Targets, the scattering medium and spectral light (§2.1).

A black and a grey target stand at each of twenty distances up to V, in one row of slots with gaps
between and nothing behind. Through the gaps an endless path is seen, in the same render. They give
β and V, in both frame drivers and in the medium. In bands of distance of `meadow` at V = 5 km the
closed form is compared with the medium that scatters light, and RGB with spectral haze by
CIEDE2000. All samples are integers: radiance in 10⁻⁹, ΔE in 10⁻³.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial

import numpy as np
from jaxtyping import Float64
from scipy.optimize import brentq

from bench.experiment import Case, Experiment, Topic
from bench.plots import Curve, Plot, curves
from bench.records.claims import Claim, Kind, at_most, claim, within
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point, Record, columns, grouped, where
from bench.statistics.estimates import Estimate, two_sided_mean
from lod.air import Air, rgb_extinction
from lod.camera import Camera, Corner, camera_from_heading
from lod.pruner import Cut, Parts, cut_from_parts
from lod.shapes import Triangles
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, Light, Quality
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
SKY = 1e10  # the lower edge [m] of the band of rays that meet nothing


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


# Targets.

DISTANCES = 20
ALBEDOS = (0.0, 0.8)  # the albedos of black and of grey

_SLOT_PX, _EDGE_PX, _ROWS, _FOV_DEG = 6, 1, 4, 6.0
_SLOTS = 2 * len(ALBEDOS) * DISTANCES
LIGHT = Light(sun_azimuth_deg=250.0, sun_elevation_deg=35.0)
HEADING_DEG = 70.0  # the heading of the camera [degrees]; the sun stands behind it

Seen = Float64[np.ndarray, "targets bands"]


def order(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Draw the distance, 1 to DISTANCES, and the albedo of each place, (targets,) each."""
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, 0xA17))))
    place = rng.permutation(len(ALBEDOS) * DISTANCES)
    return place % DISTANCES + 1, place // DISTANCES


def camera() -> Camera:
    """Make a level camera that has all slots in view."""
    size = (_SLOT_PX * _SLOTS, _ROWS)
    return camera_from_heading(Corner(0, 0), np.zeros(3), HEADING_DEG, 0.0, _FOV_DEG, size)


def targets(visibility_m: float, seed: int) -> DisplayedRepresentation:
    """Build the squares across the view, one in every other slot."""
    eye, (step, albedo) = camera(), order(seed)
    count = len(step)
    left = _SLOT_PX * 2 * np.arange(count)
    pixel = 2 * eye.tan_half[0] / eye.width
    across = (np.stack((left, left + _SLOT_PX), axis=1) - eye.width / 2) * pixel
    up = np.array((-1.0, 1.0)) * pixel * _ROWS
    distance = visibility_m * step / DISTANCES
    depth = distance / np.hypot(1.0, across.mean(axis=1))
    x, z = across[:, [0, 1, 1, 0]], np.broadcast_to(up[[0, 0, 1, 1]], (count, 4))
    rays = eye.forward + x[..., None] * eye.right + z[..., None] * eye.up
    first = 4 * np.arange(count)[:, None, None]
    shape = Triangles(
        vertices=(depth[:, None, None] * rays).reshape(-1, 3),
        normals=np.tile(-eye.forward, (4 * count, 1)),
        colours=np.repeat(np.array(ALBEDOS)[albedo], 4)[:, None] * np.ones(3),
        faces=(first + np.array([[0, 1, 2], [0, 2, 3]])).reshape(-1, 3),
        owner=np.repeat(np.arange(count), 2),
    )
    return DisplayedRepresentation("targets", _cut(count), shape)


def _cut(count: int) -> Cut:
    zero, rows = np.zeros(count), np.arange(count)
    parts = Parts(
        position=np.zeros((count, 3)),
        centre=np.zeros((count, 3)),
        bound=zero,
        limit=zero,
        limit_offscreen=zero,
        level=np.zeros(count, np.int64),
        object=rows,
        part=rows,
        parent=np.full(count, -1),
        share=np.ones(count),
    )
    return cut_from_parts(parts, count, count)


def look_at(visibility_m: float, quality: Quality) -> tuple[Seen, Seen]:
    """Render the radiance of every target and of the path beside it, in the order of places."""
    visible = targets(visibility_m, quality.seed)
    frame = render_frame(FrameInput(camera(), (visible,), Air(visibility_m), LIGHT, quality))
    slots = frame.rgb.astype(np.float64).reshape(_ROWS, _SLOTS, _SLOT_PX, -1)
    slot = slots[:, :, _EDGE_PX:-_EDGE_PX].mean(axis=(0, 2))
    target, gap = slot[::2], slot[1::2]
    before = np.concatenate((gap[:1], gap[:-1]))
    return target, (gap + before) / 2


def extinction_seen(
    target: Seen, beyond: Seen, distance: np.ndarray, grey: np.ndarray
) -> np.ndarray:
    """Fit β of each band from black and from grey, then their standard errors, (4, bands).

    The model is ln|contrast| = ln C₀ − β·d. It is fitted by least squares with weights exp(−2·β·d),
    since noise is the same at all distances; for black targets C₀ is 1 and is not fitted.
    """
    contrast = np.abs(target / beyond - 1)
    found = [_slope(contrast[~grey], distance[~grey], False)]
    found.append(_slope(contrast[grey], distance[grey], True))
    return np.concatenate([np.array(each) for each in zip(*found, strict=True)])


def _slope(contrast: Seen, d: np.ndarray, level: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return −slope of ln(contrast) for each band, and its standard error."""
    design = np.stack((np.full_like(d, float(level)), -d / d.max()), axis=1)[:, 0 if level else 1 :]
    values, errors = [], []
    for column in contrast.T:
        root = column / column.max()
        fit, *_ = np.linalg.lstsq(design * root[:, None], np.log(column) * root, rcond=None)
        left = (np.log(column) - design @ fit) * root
        scale = left @ left / (len(d) - len(fit))
        cov = scale * np.linalg.inv((design * root[:, None]).T @ (design * root[:, None]))
        values.append(fit[-1] / d.max())
        errors.append(np.sqrt(cov[-1, -1]) / d.max())
    return np.array(values), np.array(errors)


def visibility_seen(beta: np.ndarray, error: np.ndarray) -> Estimate:
    """Estimate the V whose β are nearest to those found, by a weighted mean of logarithms [m].

    Weights are inverse variances; black targets have hardly any variance, so each relative error is
    at least 1e-4. The interval is normal, 95 % and two-sided.
    """
    relative_error = np.maximum(error / beta, 1e-4)
    weight = relative_error**-2 / np.sum(relative_error**-2)

    def miss(log_v: float) -> float:
        return float(weight @ np.log(beta / rgb_extinction(Air(float(np.exp(log_v))))))

    value = float(np.exp(brentq(miss, np.log(100.0), np.log(200e3))))
    relative = float(np.sum(relative_error**-2) ** -0.5)
    half = 1.96 * relative * value
    return Estimate(value, value - half, value + half, relative * value, 1.0, len(beta))


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
