"""Wholes and their parts: the part-whole hierarchy, hidden state, compound messages (§3.2).

* An object is assembled from parts; a whole knows the types of its parts before it has them.
* A part is hidden state of its whole. No method returns it: it is reached by messages to the whole,
  which may watch, modify or reject them (``intercept``).
* Messages name queries, which give information, and mutators, which change state.
* A change is atomic: one that is refused or ends in an error leaves every part as it was.

Compound messages: a route to a part, and the action it is asked for (§3.2, figure 4).

A message is sent to a whole, which forwards it along the route. The sender gets an Answer, or the
Refusal of the object that refused it.

>>> ask("right leg/lower leg/foot", "orientation")
<ask right leg/lower leg/foot: orientation()>
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import lru_cache, wraps
from inspect import Parameter, signature
from types import MethodType
from typing import Any, ClassVar, Concatenate, Never, ParamSpec, TypeVar

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


Receiver = TypeVar("Receiver")
Given = ParamSpec("Given")
Result = TypeVar("Result")
Method = Callable[Concatenate[Receiver, Given], Result]
Kind = TypeVar("Kind", bound="ObjectWithParts")


def query(method: Method[Receiver, Given, Result]) -> Method[Receiver, Given, Result]:
    """Let messages ask for a method: it gives information and changes nothing."""
    return _by_message(method, changes=False)


def mutator(method: Method[Receiver, Given, Result]) -> Method[Receiver, Given, Result]:
    """Let messages have a method carried out: it changes state, all or nothing.

    State is kept in attributes that are bound again, to values that never change; what a method
    alters within a list or an array of its own stays altered when the change is refused.
    """
    return _by_message(method, changes=True)


def _by_message(
    method: Method[Receiver, Given, Result], changes: bool
) -> Method[Receiver, Given, Result]:
    """Make a method one that messages name.

    Called from outside, it is a message to the object itself, which an owned part refuses.
    """
    takes = signature(method)
    given = list(takes.parameters.values())[1:]
    if any(p.kind is Parameter.KEYWORD_ONLY for p in given):
        raise TypeError(f"{method.__name__}: messages carry arguments by position only")

    @wraps(method)
    def called(self: Any, *arguments: Given.args, **named: Given.kwargs) -> Any:
        if self._acts:
            return method(self, *arguments, **named)
        bound = takes.bind(self, *arguments, **named)
        bound.apply_defaults()
        return self.receive(Message((), Action(method.__name__, bound.args[1:], changes))).value

    required = sum(p.default is Parameter.empty for p in given)
    counts = range(required, len(given) + 1)
    if any(p.kind is Parameter.VAR_POSITIONAL for p in given):
        counts = range(0)  # any number: to be bound
    called.changes, called.takes, called.counts = changes, takes, counts  # type: ignore[attr-defined]
    return called


def _rejection_reason(kind: type, action: Action) -> str:
    """Say why objects of a class cannot be sent that action; the answer is empty where they can."""
    method: Any = getattr(kind, action.name, None)
    if getattr(method, "changes", None) is action.changes:
        if len(action.arguments) in method.counts:
            return ""
        try:
            method.takes.bind(None, *action.arguments)
        except TypeError as error:
            return f"{action.name} takes {method.takes}: {error}"
        return ""
    attributes = {name: getattr(kind, name) for name in dir(kind)}
    known = [n for n, a in attributes.items() if getattr(a, "changes", None) is action.changes]
    doing = "change" if action.changes else "question"
    if not known:
        return f"understands no {doing} at all"
    closest = nearest_route((action.name,), [(name,) for name in known])[0]
    return f"understands no {doing} {action.name!r}; the nearest is {closest!r}"


class ObjectWithParts:
    """An object that can consist of parts: the abstract class at the top of figure 3 (§3.1.1).

    part_types  names of the parts and their classes, known before the whole is created. A part that
                is not given is created from its class, without arguments.
    """

    __slots__ = ("__active", "__log", "__name", "__owner", "__parts")
    __active: int
    __log: "Log | None"
    __name: str
    __owner: "ObjectWithParts | None"
    __parts: "dict[str, ObjectWithParts] | None"

    part_types: ClassVar[Mapping[str, type["ObjectWithParts"]]] = {}
    is_abstract: ClassVar[bool] = True

    def __init_subclass__(cls, abstract: bool = False) -> None:
        super().__init_subclass__()
        if "__slots__" in vars(cls):
            raise TypeError(
                f"{cls.__name__} has __slots__: what it keeps there could not be put back"
            )
        cls.is_abstract = abstract
        _check_types(cls.__name__, cls.part_types)

    def __new__(cls: type[Kind], *_: Any, **__: Any) -> Kind:
        if cls.is_abstract:
            raise TypeError(f"{cls.__name__} is abstract: make an object of one of its subclasses")
        self = super().__new__(cls)
        self.__active, self.__name = 0, cls.__name__
        self.__owner = self.__parts = self.__log = None
        return self

    def __init__(
        self,
        parts: Mapping[str, "ObjectWithParts"] | None = None,
        part_types: Mapping[str, type["ObjectWithParts"]] | None = None,
        name: str | None = None,
    ) -> None:
        """Assemble the whole, which then owns its parts: others reach them only through it.

        parts       parts that exist already, by name; none of them may have an owner
        part_types  part types in addition to those of the class, or instead of them
        name        its name in refusals while it has no owner (an owner has its own name for it)

        Raises InputError for a second assembly, an unknown name or a part with an owner.
        """
        if self.__parts is not None:
            raise InputError(str(self), "a second time", "a whole is assembled once")
        types = {**type(self).part_types, **(part_types or {})}
        _check_types(str(self), types)
        self.__name = name or type(self).__name__
        self.__parts = _assembled(str(self), types, parts or {})
        for part_name, part in self.__parts.items():
            part.__owner, part.__name = self, part_name

    def receive(self, message: Message) -> Reply:
        """Carry out a compound message, or return who refused it and why.

        A part refuses every message that does not come from its whole.

        >>> Box = type("Box", (ObjectWithParts,), {})
        >>> Box().receive(Message(("lid",), Action("part_names")))
        Refusal(who='Box', why="has no part 'lid'; it has no parts at all")
        """
        if self.__owner is not None:
            return Refusal(str(self), f"is part of {self.__owner}; send the message there")
        return self.__carry_out(message)

    def intercept(self, message: Message) -> Message | Refusal:
        """Return the message to forward to a part, here the one that arrived.

        Subclasses override it to watch messages (return them unchanged), to modify them (return
        another of the same kind) or to reject them (return ``self.refuse(why)``). A refused change
        also undoes what this method binds to its own attributes, but not what it adds to a list.
        """
        return message

    def refuse(self, why: str) -> Refusal:
        """Return a refusal in this object's name."""
        return Refusal(str(self), why)

    @query
    def part_names(self) -> tuple[str, ...]:
        """Return the names of its own parts, in order."""
        return tuple(self.__parts or ())

    @query
    def routes(self) -> tuple[Route, ...]:
        """Return the routes of all parts below this object, wholes before their parts."""
        return tuple(self.__all_routes())

    def __all_routes(self) -> list[Route]:
        found: list[Route] = []
        for name, part in (self.__parts or {}).items():
            found += [(name,), *((name, *route) for route in part.__all_routes())]
        return found

    def _ask_part(self, message: Message) -> Any:
        """Return the answer of a part below, for methods of the whole itself. Raises Refused.

        The wholes on the way intercept the message; this one does not.
        """
        return self.__carry_out(message, intercepts=False).value

    @property
    def _acts(self) -> bool:
        """Tell whether it carries out a message now, so that its own methods may be called."""
        return self.__active > 0

    @property
    def _owned_by(self) -> str:
        return "" if self.__owner is None else str(self.__owner)

    @property
    def _route(self) -> Route:
        """Return the route to this object from the whole that has no owner."""
        return () if self.__owner is None else (*self.__owner._route, self.__name)

    def __carry_out(self, message: Message, intercepts: bool = True) -> Reply:
        """Deliver the message; restore every object that it changed where no answer comes back.

        A message sent by an object that acts for a change belongs to that change.
        """
        if not message.action.changes and self.__log is None:
            return self.__deliver(message, None, intercepts)
        log: Log = []
        reply = None
        try:
            reply = self.__deliver(message, log, intercepts)
        finally:
            if not isinstance(reply, Answer):
                for part, attributes in reversed(log):
                    vars(part).clear()
                    vars(part).update(attributes)
            elif self.__log is not None:
                self.__log.extend(log)
        return reply

    def __deliver(self, message: Message, log: "Log | None", intercepts: bool = True) -> Reply:
        """Forward the message to the part at the head of the route, or carry it out here."""
        if not message.route:
            return self.__perform(message.action, log)
        if intercepts and type(self).intercept is not ObjectWithParts.intercept:
            asked, passed = message, self.__act(log, lambda: self.intercept(message))
            if isinstance(passed, Refusal):
                return passed
            if passed.action.changes != asked.action.changes:
                kind = type(self).__name__
                raise TypeError(f"{kind}.intercept turned a question and a change about")
            message = passed
            if not message.route:
                return self.__perform(message.action, log)
        if (part := (self.__parts or {}).get(message.route[0])) is not None:
            return part.__deliver(Message(message.route[1:], message.action), log)
        if not (known := self.__all_routes()):
            return self.refuse(f"has no part {message.route[0]!r}; it has no parts at all")
        closest = format_route((*self._route, *nearest_route(message.route, known)))
        why = f"has no part {message.route[0]!r}; the nearest known route is {closest!r}"
        return self.refuse(why)

    def __perform(self, action: Action, log: "Log | None") -> Reply:
        """Carry out an action on this very object."""
        if why := _rejection_reason(type(self), action):
            return self.refuse(why)
        method = getattr(type(self), action.name).__wrapped__
        reply: Reply = self.__act(log, lambda: Answer(method(self, *action.arguments)))
        if isinstance(reply, Answer) and _hands_out(reply.value):
            return self.refuse(f"{action.name} would hand out a part, which is hidden state")
        return reply

    def __act(self, log: "Log | None", act: Callable[[], Any]) -> Any:
        """Act, having noted in the log how the attributes are bound now.

        A refusal names the first object that refused, not those that forwarded it.
        """
        if log is not None:
            log.append((self, dict(vars(self))))
        before, self.__log = self.__log, log
        self.__active += 1
        try:
            return act()
        except Refused as refused:
            return Refusal(refused.who, refused.why)
        except InputError as error:
            return self.refuse(str(error))
        finally:
            self.__active -= 1
            self.__log = before

    def __str__(self) -> str:
        root: ObjectWithParts = self
        while root.__owner is not None:
            root = root.__owner
        return format_route((root.__name, *self._route))

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self}>"

    def __getstate__(self) -> Never:
        raise TypeError(f"{self} stays in its process: send its answers")


def _check_types(where: str, types: Mapping[str, type[ObjectWithParts]]) -> None:
    for name, kind in types.items():
        if not (isinstance(name, str) and name.strip() and parse_route(name) == (name,)):
            raise InputError(f"{where}.part_types", name, "a name without / and .", "try 'foot'")
        if not (isinstance(kind, type) and issubclass(kind, ObjectWithParts)):
            raise InputError(f"{where}.part_types[{name!r}]", kind, "a class of objects with parts")


def _assembled(
    whole: str, types: Mapping[str, type[ObjectWithParts]], given: Mapping[str, ObjectWithParts]
) -> dict[str, ObjectWithParts]:
    for name in given:
        if name not in types:
            nearest = nearest_route((name,), [(t,) for t in types])[0] if types else ""
            cure = f"did you mean {nearest!r}?" if types else ""
            raise InputError(f"{whole}.parts", name, "a part whose type the whole knows", cure)
    parts = {name: given[name] if name in given else kind() for name, kind in types.items()}
    seen: dict[int, str] = {}
    for name, part in parts.items():
        where = f"{whole}.parts[{name!r}]"
        if not isinstance(part, types[name]):
            raise InputError(where, part, f"of class {types[name].__name__}")
        if part._owned_by:
            rule = f"a part has one owner, and this belongs to {part._owned_by}"
            raise InputError(where, part, rule, "make another")
        if id(part) in seen:
            raise InputError(where, part, f"a part has one place; this is {seen[id(part)]!r} too")
        seen[id(part)] = name
    return parts


Log = list[tuple[ObjectWithParts, dict[str, Any]]]
"""Objects that have acted for a change, in order, with their attributes as they were before."""

_PLAIN = frozenset((float, int, bool, str, type(None)))


def _hands_out(value: Any) -> bool:
    """Tell whether an answer is, or holds, a part that has an owner."""
    if isinstance(value, (tuple, list, set, frozenset)):
        return any(_hands_out(item) for item in value if type(item) not in _PLAIN)
    value = value.__self__ if isinstance(value, MethodType) else value
    if isinstance(value, ObjectWithParts):
        return bool(value._owned_by)
    return isinstance(value, Mapping) and any(_hands_out(item) for item in value.items())
