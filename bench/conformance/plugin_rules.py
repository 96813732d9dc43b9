"""Does a representation of another package keep the rules that all others keep?"""

from collections.abc import Iterator
from functools import partial

from bench.conformance.rows import report_rows
from bench.conformance.rules import RULES, Subject, all_parts
from scenes.plugins.representation import make_representation, plugin_by_name
from scenes.terrain.terrain import Terrain

_GROUND = Terrain(seed=4, amplitude=0.4, wavelength=16.0, hurst=0.8, reach=100.0, finest=1.0)
_SEED = 5


def broken_plugin_rules(kind: str) -> dict[str, list[str]]:
    """List what a plug-in's representation breaks, rule by rule, with its default options."""
    offer = plugin_by_name(kind)
    make = partial(make_representation, kind, kind, _SEED, _GROUND, {})
    subject = Subject(make, offer.camera, offer.detail)
    made = {name: list(rule(subject)) for name, rule in RULES.items()}
    return made | {under_its_top.__name__: list(under_its_top(subject))}


def under_its_top(subject: Subject) -> Iterator[str]:
    """Nothing reaches above ``top_m`` over the highest ground."""
    it, view = subject.make(), subject.view()
    parts = all_parts(it, view)
    wholes = parts.take(parts.parent < 0)
    highest = _GROUND.bounds()[1] + it.top_m  # type: ignore[attr-defined]
    yield from report_rows(
        "a whole above top_m", wholes.centre[:, 2] + wholes.bound > highest + 1e-9
    )
