"""Messages in words: ``joe right leg/lower leg/foot orient y 40deg`` and ``joe heading``.

First comes the name of an actor or ``camera``, then the route to a part, if it is a part that is
meant, then what is asked for, then numbers. Angles may end in ``deg``, lengths in ``m``, speeds in
``m/s``; an axis is x, y, z, or three numbers.

>>> parse_words("joe right leg/lower leg/foot orient y 40deg")
Words(who='joe', part='right leg/lower leg/foot', action='orient', arguments=('y', 40.0))
>>> parse_words("joe right arm/hand where").message(changes=False)
<ask joe/right arm/hand: where()>
"""

import re
from collections.abc import Callable
from typing import Any, NamedTuple

from lod.actors.joint import RevoluteJoint
from lod.actors.message import Message, Refused, ask, change, parse_route
from lod.actors.quaternion import Quaternion, Vector, components, rotation
from lod.errors import InputError
from scenes.actors.behaviour import Acts
from scenes.actors.body import Body, CameraBody
from scenes.actors.limb import Limb

_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(deg|m/s|m|s|)")
_AXES: dict[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_KINDS = (Body, Limb, CameraBody)
_INNER = {"advance", "follow", "follow_path", "set_appearance", "guard", "frames"}
"""What is no matter of words."""

EASES: dict[str, Callable[[float], float]] = {
    "linear": lambda share: share,
    "smooth": lambda share: share * share * (3 - 2 * share),
}
"""How a change goes on from its beginning, 0, to its end, 1."""


def _actions(changes: bool) -> frozenset[str]:
    names = {name for kind in _KINDS for name in dir(kind)} - _INNER
    return frozenset(
        name
        for name in names
        if any(getattr(getattr(kind, name, None), "changes", None) is changes for kind in _KINDS)
    )


QUESTIONS, CHANGES = _actions(changes=False), _actions(changes=True)


class Words(NamedTuple):
    """A message in words: who, the route to the part, what is asked for, and with what."""

    who: str
    part: str
    action: str
    arguments: tuple[str | float, ...]

    @property
    def route(self) -> tuple[str, ...]:
        """Return the route from the scene."""
        return (self.who, *parse_route(self.part))

    def message(self, changes: bool) -> Message:
        """Build the message that these words mean."""
        build = change if changes else ask
        return build(self.route, self.action, *_arguments(self))


class Line(NamedTuple):
    """A line of a script: when it begins [s], how long it takes [s], and how it goes on."""

    at: float
    words: Words
    over: float = 0.0
    ease: str = "smooth"


def parse_words(text: str, where: str = "--say") -> Words:
    """Read a message in words. Raises InputError for what is none."""
    words = text.split()
    known = QUESTIONS | CHANGES
    found = [k for k, word in enumerate(words) if k and word in known]
    if not found:
        rule = "WHO [ROUTE] ACTION [NUMBERS]"
        raise InputError(where, text, rule, f"actions are {', '.join(sorted(known))}")
    at = found[0]
    arguments = tuple(_argument(word, where) for word in words[at + 1 :])
    return Words(words[0], " ".join(words[1:at]), words[at], arguments)


def plain(answer: Any) -> Any:
    """Give an answer as plain data: a quaternion is the list of its components x, y, z, w."""
    if isinstance(answer, Quaternion):
        return list(components(answer))
    if isinstance(answer, RevoluteJoint):
        return {"position": list(answer.position), "orientation": list(answer.turn)}
    if isinstance(answer, tuple) and hasattr(answer, "_asdict"):
        return {name: plain(value) for name, value in answer._asdict().items()}
    if isinstance(answer, tuple | list):
        return [plain(each) for each in answer]
    return answer if isinstance(answer, int | float | str | bool | None) else repr(answer)


def check_action(words: Words, changes: bool, where: str) -> None:
    """Raise InputError where words ask a question and a change is wanted, or the other way."""
    if words.action not in (CHANGES if changes else QUESTIONS):
        rule = "a change, which gives no answer" if changes else "a question, which changes nothing"
        listed = ", ".join(sorted(CHANGES if changes else QUESTIONS))
        raise InputError(where, words.action, rule, f"one of {listed}")


def cue(line: Line) -> Acts:
    """Wait for the time of a line, and carry it out, a message a frame for as long as it takes."""
    now = 0.0
    while now < line.at - 1e-9:
        now = yield None
    words, route = line.words, line.words.route
    if words.action in ("orient", "turn"):
        yield from _turned(line, now)
    elif words.action == "go":
        message = words.message(changes=True)
        wanted, reached = float(message.action.arguments[0]), False
        while not reached:
            yield message
            course = yield ask(words.who, "course")
            reached = abs(float((course.vx**2 + course.vy**2) ** 0.5) - wanted) < 1e-9
            if not reached:
                yield None
    elif line.over:
        raise Refused("/".join(route), f"{words.action} takes no time: only orient and turn do")
    else:
        yield words.message(changes=True)


def _turned(line: Line, now: float) -> Acts:
    """Turn a part about an axis of its own (orient, figure 4) or of its whole (turn)."""
    *axis, angle = _arguments(line.words)
    before: Quaternion = yield ask(line.words.route, "orientation")
    begun, share = now, 0.0
    while share < 1.0:
        share = min(1.0, (now - begun) / line.over) if line.over else 1.0
        by = rotation(axis[0], EASES[line.ease](share) * angle)
        turned = before * by if line.words.action == "orient" else by * before
        yield change(line.words.route, "orient", turned)
        if share < 1.0:
            now = yield None


def _argument(word: str, where: str) -> str | float:
    if word in _AXES:
        return word
    match = _NUMBER.fullmatch(word)
    if match is None:
        raise InputError(where, word, "a number, as 40deg, 1.4m/s or 3m, or an axis x, y or z")
    return float(match[1])


def _arguments(words: Words) -> tuple[Any, ...]:
    """Give what the action takes: an axis is a vector, and so are the numbers of place and bend."""
    given = words.arguments
    if words.action in ("orient", "turn"):
        match given:
            case (str() as axis, float() as angle):
                return _AXES[axis], angle
            case (float() as x, float() as y, float() as z, float() as angle):
                return (x, y, z), angle
        rule = "an axis and an angle: x, y, z or three numbers, then degrees"
        raise InputError(words.action, " ".join(map(str, given)), rule, "try y 40deg")
    if any(isinstance(each, str) for each in given):
        raise InputError(words.action, " ".join(map(str, given)), "numbers, no axis")
    if words.action == "place":
        if len(given) not in (2, 3):
            raise InputError("place", given, "two numbers: x and y [m]")
        return ((*given, 0.0)[:3],)
    return (given,) if words.action == "bend" else given
