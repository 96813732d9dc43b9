"""Which of an object's methods messages may name: its queries and its changing methods (§3.2)."""

from collections.abc import Callable
from functools import wraps
from inspect import Parameter, Signature, signature
from typing import Any, Concatenate, ParamSpec, TypeVar

from lod.actors.message import Action, Message, nearest_route

Self = TypeVar("Self")
Given = ParamSpec("Given")
Result = TypeVar("Result")


def query(
    method: Callable[Concatenate[Self, Given], Result],
) -> Callable[Concatenate[Self, Given], Result]:
    """Let messages ask for a method: it gives information and changes nothing."""
    return _by_message(method, changes=False)


def mutator(
    method: Callable[Concatenate[Self, Given], Result],
) -> Callable[Concatenate[Self, Given], Result]:
    """Let messages have a method carried out: it changes state, all or nothing.

    State is kept in attributes that are bound anew, to values that never change; what a method
    alters within a list or an array of its own stays altered when the change is refused.
    """
    return _by_message(method, changes=True)


def _by_message(
    method: Callable[Concatenate[Self, Given], Result], changes: bool
) -> Callable[Concatenate[Self, Given], Result]:
    """Make a method one that messages name.

    Called from outside, it is a message to the object itself, which an owned part refuses.
    """
    takes = signature(method)
    if any(p.kind is Parameter.KEYWORD_ONLY for p in takes.parameters.values()):
        raise TypeError(f"{method.__name__}: messages carry arguments by position only")

    @wraps(method)
    def called(self: Any, *arguments: Given.args, **named: Given.kwargs) -> Any:
        if self._acts:
            return method(self, *arguments, **named)
        bound = takes.bind(self, *arguments, **named)
        bound.apply_defaults()
        return self.receive(Message((), Action(method.__name__, bound.args[1:], changes))).value

    called.changes, called.takes = changes, takes  # type: ignore[attr-defined]
    called.counts = _counts(takes)  # type: ignore[attr-defined]
    return called


def rejection_reason(receiver: object, action: Action) -> str:
    """Say why ``receiver`` cannot be sent that action; the answer is empty where it can."""
    kind = type(receiver)
    method: Any = getattr(kind, action.name, None)
    if getattr(method, "changes", None) is not action.changes:
        return _not_known(kind, action)
    if len(action.arguments) in method.counts:
        return ""
    try:
        method.takes.bind(receiver, *action.arguments)
    except TypeError as error:
        return f"{action.name} takes {method.takes}: {error}"
    return ""


def plain_method(receiver: object, action: Action) -> Callable[..., Any]:
    """Return the method that an action names, as written, for an object that acts already."""
    method: Callable[..., Any] = getattr(type(receiver), action.name).__wrapped__
    return method


def _counts(takes: Signature) -> range:
    """List how many arguments a method takes beside the object; none of one that takes any."""
    given = list(takes.parameters.values())[1:]
    if any(p.kind is Parameter.VAR_POSITIONAL for p in given):
        return range(0)
    return range(sum(p.default is Parameter.empty for p in given), len(given) + 1)


def _not_known(kind: type, action: Action) -> str:
    attributes = {name: getattr(kind, name) for name in dir(kind)}
    known = [n for n, a in attributes.items() if getattr(a, "changes", None) is action.changes]
    doing = "change" if action.changes else "question"
    if not known:
        return f"understands no {doing} at all"
    closest = nearest_route((action.name,), [(name,) for name in known])[0]
    return f"understands no {doing} {action.name!r}; the nearest is {closest!r}"
