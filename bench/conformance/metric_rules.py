"""Which rules must every metric keep, in its formula and in the cuts that it makes?

The rules follow from Blake 1987 §2.4.
"""

from collections.abc import Iterator
from functools import partial

import numpy as np

from bench.conformance.rows import report_rows
from bench.conformance.rules import Rule, Subject, agrees_with_brute_force, limits_never_grow
from bench.conformance.rules import same_seed_same_bytes as same_bytes
from lod.camera import Corner, camera_from_heading
from lod.metric.family import Metric
from scenes.field.species import Species
from scenes.field.species_field import SpeciesField
from scenes.models.catalogue import model_prototypes
from scenes.plugins.entry_points import metric_by_name
from scenes.terrain.terrain import Terrain

_GROUND = Terrain(seed=4, amplitude=0.4, wavelength=16.0, hurst=0.8, reach=100.0, finest=1.0)
_EXTENT_M, _DENSITY = 6.0, 0.1
_ANGLES = (1e-5, 1e-3, 0.1)
_PARTS = 400


def broken_metric_rules(name: str) -> dict[str, list[str]]:
    """List what a metric breaks, rule by rule; an empty list for each rule that it keeps."""
    metric = metric_by_name(name)
    formula = {rule.__name__: list(rule(metric)) for rule in FORMULA}
    subject = rabbits(name)
    return formula | {rule.__name__: list(rule(subject)) for rule in CUTS}


def answers_with_distances(metric: Metric) -> Iterator[str]:
    """Every part has a limit that is not below 0, and finite where the metric says so."""
    P, R = _parts()
    for m in _ANGLES:
        D = np.asarray(metric.limit(P, R, m))
        if D.shape != P.shape or D.dtype.kind != "f":
            yield f"m = {m:g}: {D.dtype} of shape {D.shape} for parts of shape {P.shape}"
            continue
        yield from report_rows(f"m = {m:g}: a limit below 0, or no number", ~(D >= 0))
        if metric.finite:
            yield from report_rows(f"m = {m:g}: an infinite limit of a finite metric", np.isinf(D))


def knows_one_part_at_a_time(metric: Metric) -> Iterator[str]:
    """A part's limit does not depend on what else is asked, nor on when."""
    P, R = _parts()
    for m in _ANGLES:
        D, again = metric.limit(P, R, m), metric.limit(P, R, m)
        alone = np.concatenate([metric.limit(P[k : k + 1], R[k : k + 1], m) for k in range(_PARTS)])
        yield from report_rows(f"m = {m:g}: another limit when asked again", D != again)
        yield from report_rows(f"m = {m:g}: another limit when asked alone", D != alone)


def finer_detail_takes_nothing_away(metric: Metric) -> Iterator[str]:
    """A smaller m never lowers a limit, and neither does a larger P or R."""
    P, R = _parts()
    for m in _ANGLES:
        D = metric.limit(P, R, m)
        yield from report_rows(
            f"m = {m:g}: less far in finer detail", metric.limit(P, R, m / 2) < D
        )
        yield from report_rows(f"m = {m:g}: less far for a larger P", metric.limit(2 * P, R, m) < D)
        yield from report_rows(f"m = {m:g}: less far for a larger R", metric.limit(P, 2 * R, m) < D)


FORMULA = (answers_with_distances, knows_one_part_at_a_time, finer_detail_takes_nothing_away)
CUTS: tuple[Rule, ...] = (limits_never_grow, agrees_with_brute_force, same_bytes)


def _parts() -> tuple[np.ndarray, np.ndarray]:
    """Draw P and R of parts from 0.1 mm to 100 m, some with R = 0; both arrays are read-only."""
    rng = np.random.default_rng(4)
    P, R = 10.0 ** rng.uniform(-4, 2, (2, _PARTS))
    R[::5] = 0.0
    for column in (P, R):
        column.setflags(write=False)
    return P, R


def rabbits(metric: str) -> Subject:
    """Put a few rabbits in a small window of rolling ground, to be pruned by one metric."""
    kind = Species("rabbit", model_prototypes("rabbit", 1, (0.8, 1.0), False), _DENSITY)
    make = partial(SpeciesField, kind, 1, _GROUND, _EXTENT_M)
    eye = np.array((0.0, -1.2 * _EXTENT_M, 0.5))
    camera = camera_from_heading(Corner(0, 0), eye, -8.0, -4.0, 65.0, (90, 50))
    return Subject(make, camera, 0.3, (metric,))
