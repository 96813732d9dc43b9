"""Compound messages: a route to a part, and the action it is asked for (§3.2, figure 4).

A message is sent to a whole, which forwards it along the route. The sender gets an Answer, or the
Refusal of the object that refused it.

>>> ask("right leg/lower leg/foot", "orientation")
<ask right leg/lower leg/foot: orientation()>
"""

from collections.abc import Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import lru_cache
from typing import Any

from lod.errors import InputError

SEPARATOR = "/"
"""Separator of the names of a route; a dot is accepted, too."""

Route = tuple[str, ...]


class Refused(ValueError):
    """The exception of a refusal: ``who`` refused, and ``why``."""

    def __init__(self, who: str, why: str) -> None:
        self.who, self.why = who, why
        super().__init__(f"{who} refuses: {why}")


@dataclass(frozen=True, eq=False)
class Action:
    """An action that a part is asked for: one of its queries or mutators, by name."""

    name: str
    arguments: tuple[Any, ...] = ()
    changes: bool = False

    def __repr__(self) -> str:
        return f"{self.name}({', '.join(map(repr, self.arguments))})"


@dataclass(frozen=True, eq=False)
class Message:
    """A compound message: the names on the way to the part, and the action.

    Each whole on the way reads the route as seen from itself: forwarding drops the first name.
    """

    route: Route
    action: Action

    def __repr__(self) -> str:
        kind = "change" if self.action.changes else "ask"
        return f"<{kind} {format_route(self.route) or 'itself'}: {self.action!r}>"


@dataclass(frozen=True, eq=False)
class Answer:
    """The reply of a part that carried out the action; ``value`` is what its method returned."""

    value: Any


@dataclass(frozen=True)
class Refusal:
    """The reply that an action was refused.

    who  route of the object that refused, from the whole that the message was sent to
    why  its reason
    """

    who: str
    why: str

    @property
    def value(self) -> Any:
        """Raise Refused: a refusal has no value to read."""
        raise Refused(self.who, self.why)


Reply = Answer | Refusal


def ask(route: str | Sequence[str], name: str, *arguments: Any) -> Message:
    """Build a message that asks for the query ``name`` of the part at ``route`` ("": the whole)."""
    return Message(parse_route(route), Action(name, arguments))


def change(route: str | Sequence[str], name: str, *arguments: Any) -> Message:
    """Build a message that asks for a change by the mutator ``name`` of the part at ``route``."""
    return Message(parse_route(route), Action(name, arguments, changes=True))


def parse_route(route: str | Sequence[str]) -> Route:
    """Split a route written with slashes or dots into names, or check those given one by one."""
    try:
        return _names(route if isinstance(route, str) else tuple(route))
    except TypeError:  # not to be kept, as a list in it
        raise _no_route(route) from None


@lru_cache(maxsize=4096)
def _names(route: str | Route) -> Route:
    if isinstance(route, str):
        names = route.replace(".", SEPARATOR).split(SEPARATOR) if route else []
    else:
        names = list(route)
    for name in names:
        if not (isinstance(name, str) and name.strip()):
            raise _no_route(route)
    return tuple(name.strip() for name in names)


def _no_route(route: object) -> InputError:
    return InputError("route", route, "names with one / between them", 'try "leg/foot"')


def format_route(route: Sequence[str]) -> str:
    """Write a route as text."""
    return SEPARATOR.join(route)


def nearest_route(route: Route, known: Sequence[Route]) -> Route:
    """Find the known route that is most similar to ``route``, by its last name and as a whole.

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
