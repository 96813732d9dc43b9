"""Which known route an unknown one was most likely meant to be."""

from collections.abc import Sequence
from difflib import SequenceMatcher

from lod.actors.message import Route, format_route


def nearest_route(route: Route, known: Sequence[Route]) -> Route:
    """The known route most like ``route``: in the part it leads to, and on the way there.

    >>> nearest_route(("foot",), [("arm", "hand"), ("leg", "foot")])
    ('leg', 'foot')
    """
    return max(known, key=lambda other: _likeness(route, other))


def _likeness(route: Route, other: Route) -> tuple[float, float]:
    whole = _ratio(route, other)
    # Names on the way are easily left out, the last one is not.
    end = max(whole, _ratio(route, other[-len(route) :]))
    return end + _ratio(route[-1:], other[-1:]), whole


def _ratio(a: Sequence[str], b: Sequence[str]) -> float:
    return SequenceMatcher(None, format_route(a), format_route(b), autojunk=False).ratio()
