"""Experiments in the form of before they were one object in one file: gone once all are."""

import importlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bench.experiment import Experiment as NewExperiment
from bench.experiment import Topic


@dataclass(frozen=True)
class Effort:
    """How much a run measures, as named sizes."""

    name: str
    sizes: Mapping[str, Any]

    def __getitem__(self, name: str) -> Any:
        return self.sizes[name]


@dataclass(frozen=True)
class Lazy:
    """A function of a module that is imported when it is first called."""

    module: str
    name: str

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Import the module and call the function."""
        return getattr(importlib.import_module(self.module), self.name)(*arguments, **named)


@dataclass(frozen=True)
class OldCases:
    """Cases from an effort."""

    cases: Lazy

    def __call__(self, topic: str, sizes: Mapping[str, Any], *more: Any) -> Any:
        """Give the cases."""
        return self.cases(Effort(topic, sizes), *more)


_MODULES = {
    **dict.fromkeys(("cases", "measure", "scene_hash", "notes"), "measure"),
    "judge": "claims",
    **dict.fromkeys(("plots", "point_table", "summary", "tables"), "plots"),
}


def functions_of(package: str, *more: str, **elsewhere: str) -> dict[str, Any]:
    """Return the functions of an experiment by their names."""
    optional = {"notes", "summary", "tables"}.difference(more)
    modules = {name: at for name, at in _MODULES.items() if name not in optional} | elsewhere
    return {
        name: Lazy(module if "." in module else f"{package}.{module}", name)
        for name, module in modules.items()
    }


def Experiment(**old: Any) -> NewExperiment:
    """Make an experiment of one topic from the old form."""
    seconds = old.pop("expected_seconds")
    topic = Topic(
        about=old.pop("about"),
        full=old.pop("full"),
        quick=old.pop("quick"),
        seconds=(seconds["full"], seconds["quick"]),
        apart=old.pop("apart", False),
    )
    for gone in ("scene_hash", "point_table", "summary", "notes"):
        old.pop(gone, None)
    return NewExperiment(
        topics={old["name"]: topic},
        cases=OldCases(old.pop("cases")),
        claims=old.pop("judge"),
        **old,
    )
