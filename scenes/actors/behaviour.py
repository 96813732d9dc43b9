"""What a behaviour is: a plain generator that sees the world only by the answers to messages.

>>> def greet(me):
...     heading = yield ask("ann", "heading")
...     yield change(me.name, "place", (0.0, 1.0, 0.0))
...     now = yield  # nothing more to do for now; goes on at its next update, told the time [s]

A yield gives the value of the answer, and raises ``Refused`` there where the message is refused. A
generator that ends leaves its actor as it is.
"""

import hashlib
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field
from types import GeneratorType
from typing import Any

import numpy as np

from lod.actors.message import Message, Refusal, Refused
from lod.actors.object_with_parts import ObjectWithParts
from lod.errors import InputError
from scenes.processes.signals import came_from_outside

MOST_MESSAGES = 2000
"""Messages that a behaviour may send at one update."""

Attend = Callable[[str], object]
Acts = Generator[Message | None, Any, None]


@dataclass(frozen=True)
class Me:
    """What a behaviour is told of the actor that it moves.

    rng      its own random numbers, by the scene's seed and its name
    options  of the preset
    """

    name: str
    rng: np.random.Generator
    options: Mapping[str, bool | int | float | str] = field(default_factory=dict)

    def option(self, name: str, default: float) -> float:
        """Return an option that is a number. Raises InputError for anything else."""
        value = self.options.get(name, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"actors.{self.name}.options.{name}", value, "a number")
        return float(value)

    def text(self, name: str) -> str:
        """Return an option that is text. Raises InputError where it is missing."""
        value = self.options.get(name)
        if not isinstance(value, str) or not value:
            raise InputError(f"actors.{self.name}.options.{name}", value, "a name in quotes")
        return value


Behaviour = Callable[[Me], Acts]


def own_random_numbers(seed: int, name: str) -> np.random.Generator:
    """Return the random numbers of one actor, which follow from the seed and its name alone."""
    digest = hashlib.blake2b(name.encode(), digest_size=8, person=b"lodbench actor").digest()
    words = seed, int.from_bytes(digest, "little")
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(words)))


class Process:
    """A behaviour while it goes on; ``where`` is what errors call it."""

    def __init__(self, where: str, acts: object) -> None:
        if not isinstance(acts, GeneratorType):
            rule = "a behaviour is a generator: it yields messages"
            raise InputError(where, type(acts).__name__, rule, "use yield in it")
        self.where = where
        self._acts: Acts = acts
        self._begun = self._busy = self.ended = False

    def update(self, stage: ObjectWithParts, now_s: float, attend: Attend) -> None:
        """Let it act until it waits for its next update; nothing where it acts already.

        attend  called with the name of whoever is sent a message, before it is sent

        Raises InputError, in one line, for whatever it does that no behaviour may.
        """
        if self._busy or self.ended:
            return
        self._busy = True
        try:
            self._run(stage, now_s, attend)
        except StopIteration:
            self.ended = True
        except InputError:
            raise
        except Refused as refused:
            raise InputError(self.where, refused.who, f"refuses: {refused.why}") from None
        except BaseException as error:
            if came_from_outside(error):
                raise
            text = " ".join(str(error).split())
            raise InputError(self.where, type(error).__name__, text or "it ended so") from None
        finally:
            self._busy = False

    def _run(self, stage: ObjectWithParts, now_s: float, attend: Attend) -> None:
        """Pass messages and answers on. Raises StopIteration at its end."""
        told: Any = now_s if self._begun else None
        self._begun = True
        sent: Any = self._acts.send(told)
        for _ in range(MOST_MESSAGES):
            if sent is None:
                return
            if not isinstance(sent, Message):
                rule = "a behaviour yields messages (ask, change) or nothing"
                raise InputError(self.where, sent, rule)
            if sent.route:
                attend(sent.route[0])
            reply = stage.receive(sent)
            if isinstance(reply, Refusal):
                sent = self._acts.throw(Refused(reply.who, reply.why))
            else:
                sent = self._acts.send(reply.value)
        rule = f"at most {MOST_MESSAGES} messages at one update"
        raise InputError(self.where, "more", rule, "yield nothing now and then, to wait")
