"""Metrics, representations and behaviours that other installed packages bring.

A package names its metrics (``lod.metric.Metric``) in the entry points of the group
``lodbench.metrics``, its makers of representations (``RepresentationPlugin``) in the group
``lodbench.representations``, and its behaviours of actors (``scenes.actors.acting``) in the
group ``lodbench.behaviours``. A package is imported only when something of it is asked for.
"""

import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from typing import Any

import numpy as np

from lod.camera import Camera
from lod.errors import InputError
from lod.metric import METRICS, Metric
from lod.pruner import Representation
from scenes.ground.relief import Ground
from scenes.processes.streams import stdout_to_stderr

METRIC, REPRESENTATION = "lodbench.metrics", "lodbench.representations"
BEHAVIOUR = "lodbench.behaviours"
GROUPS = METRIC, REPRESENTATION, BEHAVIOUR

_P = _R = np.array((0.01, 1.0, 30.0))


class PluginError(Exception):
    """Code of another package went wrong; the error's kind and what it says."""


@contextmanager
def guarded() -> Iterator[None]:
    """Run code of another package: what it prints goes to stderr, what it raises is caught.

    Raises PluginError, which names the error, for all but Ctrl-C; for ``sys.exit``, too. A process
    that forks there ends there.
    """
    process = os.getpid()
    try:
        with stdout_to_stderr():
            yield
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        raise PluginError(f"{type(error).__name__}: {error}") from error
    finally:
        if os.getpid() != process:
            os._exit(1)


@cache
def installed(group: str) -> Mapping[str, Any]:
    """Find the entry points of a group by name, except those named as our own metrics are."""
    ours = METRICS if group == METRIC else {}
    found = entry_points(group=group)
    in_order = sorted(found, key=lambda each: (each.name, each.value))
    return {each.name: each for each in in_order if each.name not in ours}


def distribution(entry: Any) -> str:
    """Format the name and version of the package that brings an entry point."""
    return f"{entry.dist.name} {entry.dist.version}" if entry.dist else "an unnamed package"


def load_entry(group: str, name: str, kind: type) -> Any:
    """Import an object of an installed package; raises InputError if it fails or is no ``kind``."""
    entry = installed(group)[name]
    where, cure = f"{group} {name}", f"mend or remove {distribution(entry)}"
    try:
        with guarded():
            found = entry.load()
    except PluginError as error:
        raise InputError(where, entry.value, f"can be imported ({error})", cure) from None
    if not isinstance(found, kind):
        rule = f"is a {kind.__module__}.{kind.__name__}"
        raise InputError(where, entry.value, f"{rule}, not {type(found).__name__}", cure)
    return found


def packages() -> dict[str, str]:
    """Collect the names and versions of all packages that bring something."""
    entries = (e for group in GROUPS for e in installed(group).values())
    return {e.dist.name: e.dist.version for e in entries if e.dist}


def modules() -> tuple[str, ...]:
    """Collect the names of the topmost modules of all that packages bring."""
    entries = (e for group in GROUPS for e in installed(group).values())
    return tuple(sorted({re.split(r"[.:]", entry.value, maxsplit=1)[0] for entry in entries}))


def metric_names() -> tuple[str, ...]:
    """List the names of the metric family and of every installed metric."""
    return (*METRICS, *installed(METRIC))


@cache
def metric_by_name(name: str) -> Metric:
    """Find a metric of the family or an installed one; raises InputError for all others."""
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
    """Say what is wrong with a metric's limits for three parts; None where nothing is."""
    try:
        with guarded(), np.errstate(all="ignore"):
            D = np.asarray(metric.limit(_P, _R, 1e-3), np.float64)
    except PluginError as error:
        return str(error)
    if D.shape != _P.shape:
        return f"shape {D.shape} for P and R of shape {_P.shape}"
    if np.isnan(D).any() or (D < 0).any():
        return f"{D.tolist()} for P and R of {_P.tolist()} m"
    if metric.finite and np.isinf(D).any():
        return "infinite, of a metric that says it is finite"
    return None


def described(group: str, kind: type) -> Iterable[tuple[str, str]]:
    """Give the name and a line about each installed object, or what is wrong with it."""
    for name, entry in installed(group).items():
        try:
            found = metric_by_name(name) if kind is Metric else load_entry(group, name, kind)
        except InputError as error:
            yield name, f"broken: {error}"
        else:
            yield name, f"{found.about} (from {distribution(entry)})"


@dataclass(frozen=True, eq=False)
class RepresentationPlugin:
    """The value of an entry point of ``lodbench.representations``.

    about   one line about it, for `lodbench list`
    make    function (name, seed, ground, **options) → a Representation of that name, which
            is the same for the same arguments; options are the keys of the preset's table, and each
            has a default
    camera  camera of the conformance tests: some of the representation is in view and some is not,
            and it is near enough for parts of parts to be displayed
    detail  τ at which that camera displays some parts and not all [px]
    """

    about: str
    make: Callable[..., Representation]
    camera: Camera
    detail: float = 1.0


def plugin_by_name(name: str) -> RepresentationPlugin:
    """Find an installed plug-in; raises InputError for an unknown one and a broken one."""
    known = installed(REPRESENTATION)
    if name not in known:
        rule = f"one that is installed: {', '.join(known) or 'none is'}"
        raise InputError("representation", name, rule, "see `lodbench list`")
    found: RepresentationPlugin = load_entry(REPRESENTATION, name, RepresentationPlugin)
    return found


def make_representation(
    name: str, kind: str, seed: int, ground: Ground, options: dict[str, Any]
) -> Representation:
    """Make a representation as a preset asks for it; raises InputError where that fails."""
    plugin = plugin_by_name(kind)
    where = f"representations.{name}"
    cure = f"see what {distribution(installed(REPRESENTATION)[kind])} says"
    try:
        with guarded():
            made = plugin.make(name, seed, ground, **options)
    except PluginError as error:
        if isinstance(error.__cause__, InputError):
            raise error.__cause__ from None
        rule = f"options that {kind} takes ({error})"
        raise InputError(where, options, rule, cure) from None
    if not isinstance(made, Representation) or made.name != name:
        rule = f"{kind} makes a representation called {name}"
        raise InputError(where, type(made).__name__, rule, cure)
    return made
