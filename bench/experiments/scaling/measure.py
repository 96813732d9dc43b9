"""Does the number of objects and parts in a frame follow K(P+R)², prefactor and all? (§4.1)"""

from collections.abc import Sequence
from dataclasses import dataclass

from bench.experiments.scaling.cases_beyond import beyond_cases
from bench.experiments.scaling.claims import noise_of
from bench.experiments.scaling.count_field import COLUMNS, count_field, seed_of
from bench.experiments.scaling.prediction import predict
from bench.fields.cases import Case, metric_cases
from bench.fields.cases import cases as even_cases
from bench.old_experiment import Effort
from bench.records.records import Point, columns, predictions
from bench.statistics.estimates import fields_needed
from bench.statistics.samples import StoppingRule, sample, worst_error

_JUDGED = 2
"""The number of columns, objects and parts displayed, that decide how many fields there are."""


@dataclass(frozen=True)
class SampledCase:
    """A case, and the rule that says when it has enough fields."""

    case: Case
    rule: StoppingRule

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.case.species}, {self.case.metric}, {self.case.sweep}"


def cases(effort: Effort, metric: str | None = None) -> list[SampledCase]:
    """Return the whole grid: even, flat, clear ground, and what is beyond; ``metric`` is in it."""
    more = metric_cases(metric) if metric else ()
    return sampled_cases((*even_cases(), *beyond_cases(), *more), effort)


def sampled_cases(grid: Sequence[Case], effort: Effort) -> list[SampledCase]:
    """Return cases with the rule that an effort makes for their fields."""
    return [SampledCase(case, StoppingRule(**effort.sizes)) for case in grid]


def measure(sampled: SampledCase, seed: int) -> Point:
    """Measure as many independent fields of the case as its means need."""
    case, rule = sampled.case, sampled.rule
    law = predict(case)
    pairs = (law.objects, law.objects_variance), (law.parts, law.parts_variance)
    needed = max(fields_needed(mean, variance, rule.target) for mean, variance in pairs)
    rows = sample(lambda i: count_field(case, seed_of(case, seed, i)), needed, _JUDGED, rule)
    samples = dict(zip(COLUMNS, map(list, zip(*rows, strict=True)), strict=True))
    return Point(case.as_json(), predictions(law.as_json()), columns(samples))


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, object]:
    """Return the sampling's target, what was reached, which points hit the cap, and the noise."""
    errors, capped = [], []
    for number, point in enumerate(points):
        table = list(zip(*(each.values for each in point.samples), strict=True))
        errors.append(worst_error(table, _JUDGED))
        if len(table) >= effort["most"] and errors[-1] >= effort["target"]:
            capped.append(number)
    return {
        "target_standard_error": effort["target"],
        "worst_standard_error": round(max(errors), 6),
        "fields": sum(len(point.column(COLUMNS[0])) for point in points),
        "most_fields_per_point": effort["most"],
        "capped_points": capped,
        "variance_measured_over_predicted": noise_of(points),
    }
