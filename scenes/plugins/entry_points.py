"""What other packages bring, by entry points: metrics and representations.

A package names its metrics (``lod.metric.family.Metric``) in the group ``lodbench.metrics``, and
what
makes its representations (``scenes.plugins.representation.RepresentationPlugin``) in
``lodbench.representations``. It is imported
when something of it is asked for, so that one that is broken is in nobody else's way.
"""

from collections.abc import Iterable
from functools import cache
from importlib.metadata import entry_points
from typing import Any, Protocol, runtime_checkable

import numpy as np

from lod.errors import InputError
from lod.metric.family import METRICS, Metric

METRIC, REPRESENTATION = "lodbench.metrics", "lodbench.representations"

_P = _R = np.array((0.01, 1.0, 30.0))


@runtime_checkable
class EntryPoint(Protocol):
    """An entry point, of the standard library or of ``importlib_metadata``, which takes its place
    wherever something has imported that."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def value(self) -> str:
        """module:object."""

    @property
    def module(self) -> str:
        """The module alone."""

    @property
    def dist(self) -> Any:
        """The package that brings it, if it is known."""

    def load(self) -> Any:
        """Import it."""


@cache
def installed(group: str) -> dict[str, EntryPoint]:
    """Entry points of a group by name; a name of our own is never another's."""
    ours = METRICS if group == METRIC else {}
    found = entry_points(group=group)
    return {each.name: each for each in sorted(found, key=_origin) if each.name not in ours}


def distribution(entry: EntryPoint) -> str:
    """The package that brings it, with its version."""
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist else "an unnamed package"


def load_entry(group: str, name: str, kind: type) -> Any:
    """What an installed package calls by that name. Raises InputError where it cannot be had."""
    entry = installed(group)[name]
    where, cure = f"{group} {name}", f"mend or remove {distribution(entry)}"
    try:
        found = entry.load()
    except Exception as error:  # whatever a stranger's code does
        said = f"{type(error).__name__}: {error}"
        raise InputError(where, entry.value, f"can be imported ({said})", cure) from None
    if not isinstance(found, kind):
        rule = f"is a {kind.__module__}.{kind.__name__}"
        raise InputError(where, entry.value, f"{rule}, not {type(found).__name__}", cure)
    return found


def packages() -> dict[str, str]:
    """Name and version of every package that brings anything."""
    entries = (e for group in (METRIC, REPRESENTATION) for e in installed(group).values())
    return {e.dist.name: e.dist.version for e in entries if e.dist}


def modules() -> tuple[str, ...]:
    """The topmost modules of all that is brought."""
    entries = (e for group in (METRIC, REPRESENTATION) for e in installed(group).values())
    return tuple(sorted({entry.module.partition(".")[0] for entry in entries}))


def metric_names() -> tuple[str, ...]:
    """The family and every installed metric."""
    return (*METRICS, *installed(METRIC))


@cache
def metric_by_name(name: str) -> Metric:
    """One of the family, or an installed one. Raises InputError for others, and broken ones."""
    if name in METRICS:
        return METRICS[name]
    if name not in installed(METRIC):
        rule = f"one of {', '.join(metric_names())}"
        raise InputError("metric", name, rule, "see `lodbench list`")
    found: Metric = load_entry(METRIC, name, Metric)
    entry = installed(METRIC)[name]
    where, cure = f"{METRIC} {name}", f"mend or remove {distribution(entry)}"
    if found.name != name:
        raise InputError(where, found.name, "is called as its entry point is", cure)
    if (wrong := _no_limits(found)) is not None:
        raise InputError(where, entry.value, f"limits are distances ({wrong})", cure)
    return found


def _no_limits(metric: Metric) -> str | None:
    """What is wrong with its limits for three parts; None where nothing is."""
    try:
        with np.errstate(all="ignore"):
            D = np.asarray(metric.limit(_P, _R, 1e-3), np.float64)
    except Exception as error:  # whatever a stranger's code does
        return f"{type(error).__name__}: {error}"
    if D.shape != _P.shape:
        return f"shape {D.shape} for P and R of shape {_P.shape}"
    if np.isnan(D).any() or (D < 0).any():
        return f"{D.tolist()} for P and R of {_P.tolist()} m"
    if metric.finite and np.isinf(D).any():
        return "infinite, of a metric that says it is finite"
    return None


def described(group: str, kind: type) -> Iterable[tuple[str, str]]:
    """Name and a line on every installed one; of a broken one, what is wrong with it."""
    for name, entry in installed(group).items():
        try:
            found = metric_by_name(name) if kind is Metric else load_entry(group, name, kind)
        except InputError as error:
            yield name, f"broken: {error}"
        else:
            yield name, f"{found.about} (from {distribution(entry)})"


def _origin(entry: EntryPoint) -> tuple[str, str]:
    return entry.name, entry.value
