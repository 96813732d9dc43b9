"""Does the number of objects and parts in a frame follow K(P+R)², prefactor and all? (§4.1)"""

import time

from bench.experiments.scaling.cases_beyond import beyond_cases
from bench.experiments.scaling.claims import judge, noise_of
from bench.experiments.scaling.count_field import COLUMNS, count_field, scene_hash, seed_of
from bench.experiments.scaling.prediction import predict
from bench.fields.cases import Case, metric_cases
from bench.fields.cases import cases as even_cases
from bench.records.provenance import provenance
from bench.records.records import Point, Record
from bench.runner.dask_cases import CaseExecutor, serial_executor
from bench.runner.experiment import Progress, silent
from bench.runner.run_cases import make_record, run_cases
from bench.statistics.estimates import fields_needed
from bench.statistics.sample_size import Effort, sample, worst_error

NAME, VERSION = "scaling", 2

FULL = Effort(target=0.005, least=4, most=20_000)
QUICK = Effort(target=0.02, least=2, most=2_000)

_JUDGED = 2
"""Objects and parts displayed decide how many fields there are; what was examined follows."""


def cases() -> tuple[Case, ...]:
    """The whole grid: even, flat, clear ground, and what is beyond it."""
    return (*even_cases(), *beyond_cases())


def run(
    quick: bool = False,
    progress: Progress = silent,
    seed: int = 0,
    each: CaseExecutor = serial_executor,
    metric: str | None = None,
) -> Record:
    """Measure every case and judge every claim; ``metric``: of another than its own as well."""
    start, effort = time.perf_counter(), QUICK if quick else FULL
    grid = cases() if metric is None else (*cases(), *metric_cases(metric))
    jobs = [(f"{c.species}, {c.metric}, {c.sweep}", (c, effort, seed)) for c in grid]
    points = run_cases(progress, each, (measure, jobs))
    return make_record(
        NAME,
        VERSION,
        quick=quick,
        provenance=provenance(scene_hash(grid), seed),
        points=points,
        claims=judge(points),
        notes={
            **_sampling_notes(points, effort),
            "variance_measured_over_predicted": noise_of(points),
        },
        start=start,
    )


def measure(case: Case, effort: Effort, seed: int) -> Point:
    """As many independent fields of the case as its means need."""
    law = predict(case)
    pairs = (law.objects, law.objects_variance), (law.parts, law.parts_variance)
    needed = max(fields_needed(mean, variance, effort.target) for mean, variance in pairs)
    rows = sample(lambda i: count_field(case, seed_of(case, seed, i)), needed, _JUDGED, effort)
    columns = zip(*rows, strict=True)
    samples = {name: list(column) for name, column in zip(COLUMNS, columns, strict=True)}
    return Point(case.as_json(), law.as_json(), samples)


def _sampling_notes(points: tuple[Point, ...], effort: Effort) -> dict[str, object]:
    """How it was sampled: the target, what was reached, and which points hit the cap."""
    errors, capped = [], []
    for number, point in enumerate(points):
        table = list(zip(*point.samples.values(), strict=True))
        errors.append(worst_error(table, _JUDGED))
        if len(table) >= effort.most and errors[-1] >= effort.target:
            capped.append(number)
    return {
        "target_standard_error": effort.target,
        "worst_standard_error": round(max(errors), 6),
        "fields": sum(len(point.samples[COLUMNS[0]]) for point in points),
        "most_fields_per_point": effort.most,
        "capped_points": capped,
    }
