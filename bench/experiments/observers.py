"""At which τ do people see what was left out? Answers of people, and the proof on simulated ones.

``answers`` holds what people answered; its records are written by ``lodbench observe fit``, for no
program can measure it. ``simulated`` sends observers of a stated model through the same protocol
and the same fit: thresholds must come out without bias, intervals must cover, and whoever guesses
or often lapses must be excluded by the rules. ``predicted`` asks models, and nobody: every preset
as shipped, still and moving, beside a reference that is up to four times as fine, from two
distances. Reference and preset have samples of their own; the reference with others tells what
grain alone does.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from scipy import stats

from bench.experiment import Case, Experiment, Table, Topic
from bench.images.as_shipped import SUNS_DEG, Place, places
from bench.images.equal_error import EQUAL_ERROR, crossings
from bench.methods.environments import VIDEO
from bench.methods.video import just_objectionable_differences
from bench.observers.make import band_contrasts, beyond_grain, radiances
from bench.observers.plan import BLOCK, CATCHES, FITTED_LEVELS, LEVELS_PX, MOST_CATCHES_MISSED, WAYS
from bench.observers.psychometric import GUESS, Fits, fit, join
from bench.observers.results import Session
from bench.observers.simulate import ObserverModel, ask
from bench.plots import Curve, Panel, Plot, estimated, figure
from bench.records.claims import EXACT, Claim, at_least, at_most, claim, within
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point, Prediction, Record, columns, grouped
from bench.runs import RunRequest, run_experiment
from bench.seeds import first_seed
from bench.statistics.estimates import Estimate, two_sided_mean, two_sided_share
from lod.errors import InputError
from lod.eye import Eye
from scenes.presets.load import load_preset, preset_names
from scenes.render.budget import reference_preset
from scenes.render.pictures import auto_exposure, to_srgb_8bit
from scenes.render.variants import choose
from scenes.scene import Scene

SHIPPED_PX = 1.0  # τ of the presets as they are shipped

MODELS = {
    "barten": ("Barten's eye", 1.0),
    "flip": (f"FLIP {EQUAL_ERROR}", EQUAL_ERROR),
    "lost": ("ColorVideoVDP, 1 JOD", 1.0),
}
"""The name of each model, and its value at its threshold."""


def no_cases() -> Sequence[Case]:
    """Refuse to measure answers of people."""
    cure = "see `lodbench observe fit -h`"
    raise InputError("EXPERIMENT", "answers", "answers come from people", cure)


def answers_record(
    sessions: Sequence[Session], plan: Mapping[str, Any], notes: Mapping[str, Any]
) -> Record:
    """Make the record of sessions. Raises InputError where no condition has two observers."""
    points, seen = [], [(each.observer, each.counts()) for each in sessions]
    for number, condition in enumerate(plan["conditions"]):
        mine = [(who, counts[number]) for who, counts in seen if number in counts]
        if len(mine) > 1:
            samples = [*columns({"observer": [who for who, _ in mine]})]
            for level in range(len(FITTED_LEVELS)):
                right, shown = ([int(each[n][level]) for _, each in mine] for n in (0, 1))
                samples += columns({"right": right, "shown": shown}, level=level)
            said = thresholds(plan["models"][condition["name"]]).items()
            predicted = tuple(Prediction("tau75", px, {"model": model}) for model, px in said)
            case = {"topic": "answers", "condition": condition["name"]}
            points.append(Point(case, predicted, tuple(samples), plan["sha256"]))
    if not points:
        rule = "2 observers of one condition, or more, who are not excluded"
        raise InputError("FILES", f"{len(sessions)} observers", rule, "ask more people")
    given = replace(EXPERIMENT.topics["answers"], cases=lambda: [partial(lambda seed: points)])
    asked = RunRequest(EXPERIMENT.name, ("answers",))
    record = run_experiment(replace(EXPERIMENT, topics={"answers": given}), asked)
    about = {"plan": plan["sha256"], "observers": len(sessions), **notes}
    return replace(record, notes=record.notes | about)


def thresholds(said: Mapping[str, Sequence[float]]) -> dict[str, float]:
    """Return τ [px] at which each model's values, of all levels, come up to its threshold."""
    found: dict[str, float] = {}
    for model, row in said.items():
        values = np.array(row)[:, None]
        px = float(crossings(np.array(LEVELS_PX), values, values, MODELS[model][1])[0, 0])
        found |= {model: px} if math.isfinite(px) else {}
    return found


def fitted(points: Sequence[Point]) -> tuple[Fits, np.ndarray, np.ndarray]:
    """Fit every observer in every condition; also return who and which condition, (n,) each."""
    levels = range(len(FITTED_LEVELS))
    right, shown = (
        np.array([[n for p in points for n in p.column(q, level=k)] for k in levels]).T
        for q in ("right", "shown")
    )
    who, which = np.array([(n, k) for k, p in enumerate(points) for n in p.column("observer")]).T
    return fit(FITTED_LEVELS, right, shown), np.unique(who, return_inverse=True)[1], which


def joined(points: Sequence[Point]) -> list[Estimate]:
    """Estimate τ₇₅ [px] of every condition over observers."""
    return [_of_log(each) for each in join(*fitted(points))[0]]


def _of_log(e: Estimate) -> Estimate:
    value, low, high = (10**each for each in (e.value, e.low, e.high))
    return Estimate(value, low, high, math.log(10) * value * e.standard_error, 1.0, e.rows)


def answer_claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Claim of every condition that who has no lapses tells the shipped τ in 75 % at most."""
    facts = partial(
        claim, "threshold τ75 [px]", at_least(SHIPPED_PX), unit="observer", source="§5.2"
    )
    for point, estimate in zip(points, joined(points), strict=True):
        yield facts({"pictures": point.case["condition"]}, estimate, headline=True)


def answer_plots(record: Record) -> Iterator[Plot]:
    """Draw τ₇₅ of every condition, beside what the models predict."""
    found, panels = joined(record.points), []
    for way in WAYS:
        name = f", {way}"
        rows = [k for k, p in enumerate(record.points) if p.case["condition"].endswith(name)]
        mine = [record.points[k] for k in rows]
        drawn = [estimated("observers", range(len(rows)), [found[k] for k in rows])] if rows else []
        for model, (label, _) in MODELS.items():
            said = [(k, e) for k, p in enumerate(mine) for e in p.predicted]
            told = {k: e.value for k, e in said if e.keys == {"model": model}}
            drawn += [Curve(label, [*told], [*told.values()])] if told else []
        ticks = [p.case["condition"].removesuffix(name) for p in mine]
        axis, scale = ("pictures", "τ75 [px]"), ("linear", "log")
        panels.append(Panel(way, axis, drawn, scale, "points", ticks))
    caption = (
        "τ at which an observer without lapses tells a pruned picture from the reference in 75 % "
        "of pairs: mean over observers and 95 % interval, beside the τ at which each model reaches "
        "its criterion for the same pairs."
    )
    yield figure("tau75", "What observers see, beside what models predict", caption, panels)


def answer_tables(record: Record) -> Iterator[tuple[str, Table]]:
    """List τ₇₅ of every observer in every condition."""
    found, *_ = fitted(record.points)
    values = zip(found.value, found.low, found.high, strict=True)
    rows = [
        (point.case["condition"], str(who), *(f"{10**each:.3g}" for each in next(values)))
        for point in record.points
        for who in point.column("observer")
    ]
    yield "τ75 of every observer", (("pictures", "observer", "τ75 [px]", "from", "to"), rows)


KINDS = {"observers": math.nan, "lapsers": 0.3, "guessers": GUESS}
"""Lapse rates of simulated observers. Lapsers look at two pairs of five, and guess the others."""


def simulated_cases(observers: int, groups: int, unseen: bool) -> Sequence[Case]:
    """Return the groups of observers, each of a seed of its own."""
    first = first_seed(unseen)
    return [partial(measure_simulated, observers // groups, first + k) for k in range(groups)]


def measure_simulated(count: int, group: int, seed: int) -> Point:
    """Send as many of each of KINDS through a block: errors in 10⁻⁶ of log₁₀ τ₇₅."""
    rng, model = np.random.default_rng([seed, group]), ObserverModel()
    asked = {kind: ask(model, np.full(count, lapse), BLOCK, rng) for kind, lapse in KINDS.items()}
    said = asked["observers"]
    one, true, means = said.fitted(), said.log75.ravel(), model.means(BLOCK)
    rows = np.arange(count * BLOCK)
    joint, _ = join(one, rows // BLOCK, rows % BLOCK)
    value, low, high = np.array([(e.value, e.low, e.high) for e in joint]).T
    samples: dict[str, Any] = {"sent": [count]}
    for of, error, covered in (
        ("one", one.value - true, (one.low <= true) & (true <= one.high)),
        ("all", value - means, (low <= means) & (means <= high)),
    ):
        of_condition = error.reshape(-1, BLOCK).mean(axis=0)
        samples[f"error_{of}"] = [round(1e6 * float(error.mean()))]
        samples[f"covered_{of}"] = [int(covered.sum())]
        samples[f"intervals_{of}"] = [len(covered)]
        samples |= {f"error_{of}_{k}": [round(1e6 * v)] for k, v in enumerate(of_condition)}
    for kind, answers in asked.items():
        missed = (~answers.correct[..., -CATCHES:]).sum(axis=(1, 2))
        samples[f"excluded_{kind}"] = [int((missed > MOST_CATCHES_MISSED).sum())]
    return Point({"topic": "simulated"}, samples=columns(samples))


def simulated_claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Claim that thresholds have no bias, that intervals cover, and who is excluded."""
    (point,) = points
    facts = partial(claim, unit="group of observers", source="protocol")
    means = ObserverModel().means(BLOCK)
    errors = {"one observer, all conditions": "error_one", "all observers": "error_all"}
    errors |= {f"all observers, {10**m:.2f} px": f"error_all_{k}" for k, m in enumerate(means)}
    for of, name in errors.items():
        ratio = _of_log(two_sided_mean(point.values(name) / 1e6))
        shown = of == "all observers"
        yield facts("fitted ÷ true τ75", within(1, 0.03), {"of": of}, ratio, headline=shown)
    shares = (
        ("coverage of 95 % intervals", "one observer", within(0.95, 0.02), "covered_one"),
        ("coverage of 95 % intervals", "all observers", within(0.95, 0.02), "covered_all"),
        ("share excluded", "observers", at_most(0.05), "excluded_observers"),
        ("share excluded", "lapsers", at_least(0.9), "excluded_lapsers"),
        ("share excluded", "guessers", at_least(0.99), "excluded_guessers"),
    )
    for estimand, of, bound, name in shares:
        out_of = name.replace("covered", "intervals") if "covered" in name else "sent"
        share = two_sided_share(point.values(name), point.values(out_of))
        shown = name == "covered_all"
        yield facts(estimand, bound, {"of": of}, share, alone=EXACT, headline=shown)


def simulated_plots(record: Record) -> Iterator[Plot]:
    """Draw what the fit makes of each true τ₇₅."""
    (point,) = record.points
    errors = [two_sided_mean(point.values(f"error_all_{k}") / 1e6) for k in range(BLOCK)]
    found = [_of_log(each) for each in errors]
    drawn = [estimated("mixed model ÷ true", [*10 ** ObserverModel().means(BLOCK)], found)]
    axis, scale = ("true τ75 [px]", "fitted ÷ true τ75"), ("log", "linear")
    panel = Panel("Bias by threshold", axis, drawn, scale, "points", between=(0.97, 1.03))
    caption = "Groups of simulated observers: mean and 95 % interval. The band is what is claimed."
    yield figure("simulated", "Thresholds of simulated observers are found", caption, [panel])


FINER = 4  # how many times as fine as the shipped one the detail of the reference is at most
DISTANCES = 60, 30  # pixels per degree: of the observers here, and of somebody half as far away

SAID = {
    "seen": ("detection probability, Barten's eye", at_most(0.5)),
    "jod": ("JOD, ColorVideoVDP", at_least(9.0)),
}
"""What models say of a preset, and what is claimed: three of four do not tell it from the finer."""


def predicted_cases(
    presets: Sequence[str],
    count: int,
    size: str,
    spp: int,
    frames: int,
    most_bytes: int,
    unseen: bool,
) -> Sequence[Case]:
    """Return presets, or every one without names, from some places, still and moving."""
    return [
        partial(measure_predicted, place, way, spp, frames, most_bytes, choose())
        for name in presets or [name for name, _ in preset_names()]
        for place in places(name, count, unseen, size)
        if place.sun in ("in turn", f"{SUNS_DEG[place.number % len(SUNS_DEG)]:g}°")
        for way in ("still", "moving")
    ]


def measure_predicted(
    place: Place, way: str, spp: int, frames: int, most_bytes: int, variant: str, seed: int
) -> Point:
    """Ask models about a preset from a place; what they say is in 10⁻⁶.

    Barten's eye looks at the first frame: a contrast of c thresholds is seen with probability
    Φ(k·(c − 1)), where k is the ratio of signal to noise at which it sees half of the time (Barten
    1999, section 2.2). A preset moves as it does, or at 1.4 m/s where its eye stands still. The
    reference is as fine as ``most_bytes`` of memory allow, up to FINER times.
    """
    VIDEO.needed()
    shipped = place.load()
    looks = [*place.settings, f"render.spp={spp}"]
    if not shipped.camera.keys:
        looks.append(f"camera.speed={(shipped.camera.speed or 1.4) * (way == 'moving')}")
    scene = Scene(load_preset(place.preset, looks))
    numbers = range(place.frame, place.frame + (frames if way == "moving" else 1))
    finest = shipped.view.detail / FINER
    finer = reference_preset(scene.preset, numbers, most_bytes, finest=finest)
    reference = scene.with_preset(finer)
    of = enumerate((reference, reference, scene), 3 * seed)
    radiance = [[*radiances(each, numbers, variant, samples)] for samples, each in of]
    exposure = auto_exposure(radiance[0][0])
    shown = [np.array([to_srgb_8bit(each, exposure) for each in row]) for row in radiance]
    whole, *both = (each.astype(np.float32) / 255 for each in shown)
    tested = dict(zip(("jod_grain", "jod"), both, strict=True))
    jod = just_objectionable_differences(tested, whole, shipped.camera.fps, DISTANCES)
    samples: list[Column] = [*columns({"reference": [round(1e6 * finer.view.detail)]})]
    for k, ppd in enumerate(DISTANCES):
        grain, pruned = (band_contrasts(each[0], shown[0][0], ppd) for each in shown[1:])
        contrast = beyond_grain(pruned, grain).max()
        said = {"seen": stats.norm.cdf(Eye().signal_to_noise * (contrast - 1))}
        said |= {name: values[k] for name, values in jod.items()}
        samples += columns({name: [round(1e6 * v)] for name, v in said.items()}, ppd=ppd)
    case = {"topic": "predicted", "preset": place.preset, "way": way}
    return Point(case, samples=tuple(samples), scene=scene_digest([looks, finest, frames]))


def predicted_claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Claim that a preset is told from the finer one in three of four pairs at most."""
    for point, (quantity, (name, bound)), ppd in product(points, SAID.items(), DISTANCES):
        estimate = two_sided_mean(point.values(quantity, ppd=ppd) / 1e6)
        at = {"preset": str(point.case["preset"]), "way": str(point.case["way"])}
        yield claim(name, bound, at | {"ppd": ppd}, estimate, unit="place", source="§1.1")


def predicted_plots(record: Record) -> Iterator[Plot]:
    """Draw what models say of every preset, from both distances."""
    by_way, panels = grouped(record.points, "way"), []
    names = [str(point.case["preset"]) for point in next(iter(by_way.values()))]
    for quantity, (name, _) in SAID.items():
        drawn = []
        for ((way,), points), ppd in product(by_way.items(), DISTANCES):
            found = [two_sided_mean(each.values(quantity, ppd=ppd) / 1e6) for each in points]
            drawn.append(estimated(f"{way}, {ppd} pixels a degree", range(len(found)), found))
        scale = "linear", "linear"
        panels.append(Panel(name, ("preset", name), drawn, scale, "points", names))
    caption = (
        "Presets as shipped beside references as fine as memory allows, up to four times as fine: "
        "mean over places."
    )
    yield figure("predicted", "What models say of presets as shipped", caption, panels)


EXPERIMENT = Experiment(
    name="observers",
    question="At which τ do people see what is left out?",
    version=1,
    topics={
        "simulated": Topic(
            about="simulated observers through the protocol: bias, coverage, exclusions",
            cases=simulated_cases,
            claims=simulated_claims,
            plots=simulated_plots,
            full={"observers": 6000, "groups": 300, "unseen": True},
            quick={"observers": 200, "groups": 10, "unseen": False},
            seconds=(120, 10),
        ),
        "predicted": Topic(
            about="what models of a viewer say of every preset as shipped, still and moving",
            cases=predicted_cases,
            claims=predicted_claims,
            plots=predicted_plots,
            full={
                "presets": [],
                "count": 3,
                "size": "640x360",
                "spp": 16,
                "frames": 4,
                "most_bytes": 10 * 10**9,
                "unseen": True,
            },
            quick={
                "presets": ["crowd", "badlands", "playground", "zoo"],
                "count": 2,
                "size": "96x54",
                "spp": 64,
                "frames": 3,
                "most_bytes": 4 * 10**9,
                "unseen": False,
            },
            seconds=(5400, 240),
            apart=True,
        ),
        "answers": Topic(
            about="answers of people, by `lodbench observe fit`",
            cases=no_cases,
            claims=answer_claims,
            plots=answer_plots,
            tables=answer_tables,
            seconds=(1, 1),
            apart=True,
        ),
    },
    caveats=(
        "Simulated observers show that the protocol is ready. They say nothing of what people see.",
    ),
    order=950,
)
