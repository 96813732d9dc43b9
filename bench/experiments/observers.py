"""At which τ do people see what was left out? Answers of people, and the proof on simulated ones.

``answers`` holds what people answered; its records are written by ``lodbench observe fit``, for no
program can measure it. ``simulated`` sends observers of a stated model through the same protocol
and the same fit: thresholds must come out without bias, intervals must cover, and whoever guesses
must be excluded by the rules.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from bench.experiment import Case, Experiment, Table, Topic
from bench.images.equal_error import EQUAL_ERROR
from bench.observers import plan as fixed
from bench.observers.plan import CATCHES, FITTED_LEVELS, LEVELS_PX, TRIALS
from bench.observers.psychometric import Fits, Joined, fit, join
from bench.observers.results import Session
from bench.observers.simulate import LAPSER, ObserverModel, ask, draw
from bench.plots import Curve, Panel, Plot, figure
from bench.records.claims import Claim, at_least, at_most, claim, within
from bench.records.records import Point, Prediction, Record, columns
from bench.seeds import first_seed
from bench.statistics.estimates import Estimate, two_sided_mean, two_sided_share
from lod.errors import InputError

SHIPPED_PX = 1.0
"""τ of the presets as they are shipped."""

CRITERIA = {"barten": (1.0, 1), "flip": (EQUAL_ERROR, 1), "jod": (9.0, -1)}
"""What a model says at its threshold, and whether it grows or falls with τ."""

MODEL_NAMES = {"barten": "Barten's eye", "flip": "FLIP 0.01", "jod": "ColorVideoVDP, 1 JOD"}


def no_cases() -> Sequence[Case]:
    """Refuse to measure answers of people."""
    cure = "see `lodbench observe fit -h`"
    raise InputError("EXPERIMENT", "answers", "answers come from people", cure)


def answer_points(
    sessions: Sequence[Session], plan: Mapping[str, Any], topic: str = "answers"
) -> list[Point]:
    """Make a point of every condition that at least two sessions saw: answers by level."""
    counts = [
        dict(zip(each.conditions, zip(*each.counts(), strict=True), strict=True))
        for each in sessions
    ]
    made = []
    for number, condition in enumerate(plan["conditions"]):
        mine = [k for k, each in enumerate(counts) if number in each]
        if len(mine) < 2:
            continue
        right, shown = (np.array([counts[k][number][which] for k in mine]) for which in (0, 1))
        samples = [*columns({"observer": [sessions[k].observer for k in mine]})]
        for level in range(len(FITTED_LEVELS)):
            row = {"right": right[:, level].tolist(), "shown": shown[:, level].tolist()}
            samples += columns(row, level=level)
        said = plan["models"][condition["name"]]
        predicted = [
            Prediction("tau75", px, {"model": model}) for model, px in thresholds(said).items()
        ]
        case = {"topic": topic, "condition": condition["name"]}
        made.append(Point(case, tuple(predicted), tuple(samples)))
    return made


def thresholds(said: Mapping[str, Sequence[float]]) -> dict[str, float]:
    """Return τ [px] at which each model's values cross its criterion, where they do.

    ``said`` has the values of all levels. Between two the value is read along the straight line
    over log τ.
    """
    found = {}
    for model, row in said.items():
        criterion, sign = CRITERIA[model]
        above = [sign * (value - criterion) for value in row[: len(LEVELS_PX)]]
        first = next((k for k, value in enumerate(above) if value >= 0), 0)
        if first:
            share = above[first - 1] / (above[first - 1] - above[first])
            found[model] = LEVELS_PX[first - 1] * 2 ** (share / 2)
    return found


def fitted(points: Sequence[Point]) -> tuple[Fits, np.ndarray, np.ndarray]:
    """Fit every observer in every condition; also return who and which condition, (n,) each."""
    levels = range(len(FITTED_LEVELS))
    right, shown = (
        np.concatenate([np.array([p.column(q, level=k) for k in levels]).T for p in points])
        for q in ("right", "shown")
    )
    who = np.concatenate([p.column("observer") for p in points])
    which = np.repeat(np.arange(len(points)), [len(p.column("observer")) for p in points])
    return fit(FITTED_LEVELS, right, shown), np.unique(who, return_inverse=True)[1], which


def joined(points: Sequence[Point]) -> tuple[tuple[Estimate, ...], Joined]:
    """Estimate τ₇₅ [px] of every condition over observers; also return the mixed model."""
    found = join(*fitted(points))
    return tuple(
        Estimate(
            10**e.value,
            10**e.low,
            10**e.high,
            np.log(10) * 10**e.value * e.standard_error,
            1.0,
            e.rows,
        )
        for e in found.thresholds
    ), found


def answer_claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Claim of every condition that half of what is left out at the shipped τ stays unseen."""
    for point, estimate in zip(points, joined(points)[0], strict=True):
        condition = {"pictures": point.case["condition"]}
        yield claim(
            "τ75 in px",
            at_least(SHIPPED_PX),
            condition,
            estimate,
            unit="observer",
            source="§1.1, §5.2",
            headline=True,
        )


def answer_plots(record: Record) -> Iterator[Plot]:
    """Draw τ₇₅ of every condition, beside what the models predict."""
    points = record.points
    estimates = joined(points)[0]
    panels = []
    for way in fixed.WAYS:
        mine = [k for k, p in enumerate(points) if p.case["condition"].endswith(f", {way}")]
        if not mine:
            continue
        x = list(range(len(mine)))
        e = [estimates[k] for k in mine]
        drawn = [
            Curve("observers", x, [v.value for v in e], [v.low for v in e], [v.high for v in e])
        ]
        for model, name in MODEL_NAMES.items():
            told = [
                (at, p.value)
                for at, k in enumerate(mine)
                for p in points[k].predicted
                if p.keys["model"] == model
            ]
            if told:
                drawn.append(Curve(name, *map(list, zip(*told, strict=True))))
        ticks = [points[k].case["condition"].removesuffix(f", {way}") for k in mine]
        panels.append(
            Panel(way, ("pictures", "τ75 [px]"), drawn, ("linear", "log"), "points", ticks)
        )
    caption = (
        "τ at which an observer without lapses tells a pruned picture from the reference in 75 % "
        "of pairs: mean over observers and 95 % interval, beside the τ at which each model reaches "
        "its criterion for the same pairs."
    )
    yield figure("tau75", "What observers see, beside what models predict", caption, panels)


def answer_tables(record: Record) -> Iterator[tuple[str, Table]]:
    """List τ₇₅ of every observer in every condition, and the deviations of the mixed model."""
    found, _, which = fitted(record.points)
    who = [n for p in record.points for n in p.column("observer")]
    rows = [
        (record.points[k].case["condition"], str(n), *(f"{10**v:.3g}" for v in values))
        for k, n, *values in zip(which, who, found.value, found.low, found.high, strict=True)
    ]
    yield "τ75 of every observer", (("pictures", "observer", "τ75 [px]", "from", "to"), rows)
    model = joined(record.points)[1]
    spread = [("observers", f"{model.observers:.3f}"), ("conditions", f"{model.conditions:.3f}")]
    yield "Standard deviations of log10 τ75", (("between", "deviation"), spread)


SIMULATED = 6
"""Conditions that each simulated observer sees."""


def simulated_cases(observers: int, groups: int, unseen: bool) -> Sequence[Case]:
    """Return the groups of observers, each of a seed of its own."""
    first = first_seed(unseen)
    return [partial(measure_simulated, observers // groups, first + k) for k in range(groups)]


def measure_simulated(count: int, field: int, seed: int) -> Point:
    """Send observers through the protocol: τ₇₅ as it is and as it is fitted, in 10⁻⁶ of log₁₀."""
    rng = np.random.default_rng([seed, field])
    people = draw(ObserverModel(), count, SIMULATED, rng)
    who, condition = np.repeat(np.arange(count), SIMULATED), np.tile(np.arange(SIMULATED), count)
    found = fit(FITTED_LEVELS, *ask(people, who, condition, TRIALS, rng))
    true = people.log75.ravel()
    joint = join(found, who, condition).thresholds
    catches = SIMULATED * CATCHES
    missed = {
        kind: rng.binomial(catches, np.broadcast_to(lapse / 2, count))
        for kind, lapse in (("observer", people.lapse), ("guesser", 1.0), ("lapser", LAPSER))
    }
    samples = {
        "error": _millionths(found.value - true),
        "covered": [int(((found.low <= true) & (true <= found.high)).sum())],
        "of": [len(true)],
        "joint_error": _millionths([e.value - m for e, m in zip(joint, people.mean, strict=True)]),
        "joint_covered": [
            int(sum(e.low <= m <= e.high for e, m in zip(joint, people.mean, strict=True)))
        ],
        "joint_of": [len(joint)],
    }
    samples |= {
        f"excluded_{kind}": [int((row > fixed.MOST_CATCHES_MISSED).sum())]
        for kind, row in missed.items()
    }
    return Point(
        {"topic": "simulated", "observers": count}, samples=columns(samples | {"sent": [count]})
    )


def _millionths(values: Any) -> list[int]:
    return np.rint(1e6 * np.mean(np.reshape(values, (-1, SIMULATED)), axis=1)).astype(int).tolist()


def simulated_claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Claim that thresholds have no bias, that intervals cover, and that rules exclude."""
    (point,) = points
    condition = {"trials": f"{TRIALS} and {CATCHES} catch trials"}
    facts = {"unit": "observer", "source": "protocol"}
    for what, of in (("error", "one observer"), ("joint_error", "all observers")):
        e = two_sided_mean(point.values(what) / 1e6)
        ratio = Estimate(10**e.value, 10**e.low, 10**e.high, e.standard_error, 1.0, e.rows)
        yield claim(
            "τ75 fitted ÷ true",
            within(1, 0.03),
            {"of": of, **condition},
            ratio,
            headline=True,
            **facts,
        )
    for what, of in (("", "one observer"), ("joint_", "all observers")):
        share = two_sided_share(point.values(f"{what}covered"), point.values(f"{what}of"))
        yield claim(
            "coverage of 95 % intervals",
            within(0.95, 0.02),
            {"of": of, **condition},
            share,
            headline=True,
            **facts,
        )
    for kind, bound in (
        ("observer", at_most(0.02)),
        ("guesser", at_least(0.99)),
        ("lapser", at_least(0.9)),
    ):
        share = two_sided_share(point.values(f"excluded_{kind}"), point.values("sent"))
        yield claim("share excluded", bound, {"who": kind, **condition}, share, **facts)


EXPERIMENT = Experiment(
    name="observers",
    question="At which τ do people see what is left out?",
    version=1,
    topics={
        "simulated": Topic(
            about="simulated observers through the protocol: bias, coverage, exclusions",
            cases=simulated_cases,
            claims=simulated_claims,
            full={"observers": 6000, "groups": 300, "unseen": True},
            quick={"observers": 200, "groups": 10, "unseen": False},
            seconds=(120, 10),
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
