"""How a scene acts, frame by frame: cues of the script, then behaviours, the most urgent first.

With a threshold, an actor is updated when it may be off by more than that on the image, or has
coasted for ``LONGEST_COAST_S``, or is sent a message: whoever is asked is brought up to date first.
With a budget no more than so many are, the most urgent first.

**The temporal metric of actors** (§2): by how much may an actor that coasts be off on the image?
A body keeps its speed and its rate of turning until it is told to go otherwise, and both change by
no more than ``ACCELERATION`` a and ``SPIN_ACCELERATION`` α a second since it was told.
So t seconds after that, against a body that was told again all the time, with v its speed, u and Δ
that speed and a·t as shares of its own walk's,

    its place is off by at most    a·t²/2 + v·α·t³/6,
    its parts, for its turning, by r·min(α·t²/2, 2),
    for its cadence by             w·c·a·t²/2, c the steepest rise of the cadence near u,
    for its stride by              1.5·l·|f − f(u)|, f the stride at u − Δ or u + Δ,
    for feet that stay planted by  min(p·|log(f/f(u))|, 2·l),
    and where it shuffles by       l·min(1, Δ/SLOWEST + 1/8) + w·v'·t,

where r is how far it reaches from the vertical through its place, w the speed of its fastest part
against its own, p how far such a part goes in a cycle times the share of it by which the prints of
standing feet lie ahead at most (``scenes.actors.limb.planted_phase``), l how far a part is at most
from where it rests, and v' the speed whose strides are as quick as those of ``SLOWEST``; it may
shuffle where u − Δ is below that. Seen from a distance d, that is (the sum)/((d − b)·θ) pixels, b
its bound. It holds over level ground. What messages hold is not in it: whose limbs were moved by
the last update is updated in every frame, and r of whom a message holds is b.

What a behaviour is: a plain generator that sees the world only by the answers to messages.

>>> def greet(me):
...     heading = yield ask("ann", "heading")
...     yield change(me.name, "place", (0.0, 1.0, 0.0))
...     now = yield  # nothing more to do for now; goes on at its next update, told the time [s]

A yield gives the value of the answer, and raises ``Refused`` there where the message is refused. A
generator that ends leaves its actor as it is.
"""

import hashlib
import math
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from types import GeneratorType
from typing import Any

import numpy as np

from lod.actors.object_with_parts import Message, ObjectWithParts, Refusal, Refused, ask, change
from lod.arrays import ArrayData, Flags, FloatArray, Reals
from lod.errors import InputError
from scenes.actors.body import ACCELERATION, SPIN_ACCELERATION, reach_in_plan
from scenes.actors.limb import (
    EIGHTHS,
    LONGEST_STRIDE,
    SLOWEST,
    STRIDE_POWER,
    prints_ahead,
    stick_ends,
)
from scenes.actors.performance import ActedFrame, Eye, Held, X, Y
from scenes.actors.stage import CAMERA, Stage, Standings
from scenes.models.catalogue import at_rest
from scenes.processes.streams import came_from_outside
from scenes.rig.rigged_prototype import RiggedPrototype

MOST_MESSAGES = 2000  # messages that a behaviour may send at one update

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


@dataclass(frozen=True, eq=False)
class MotionBounds(ArrayData):
    """How much of n bodies may move, (n,) each.

    bound   B of the whole [m]
    reach   r, from the vertical through its place [m]
    walk    w
    planted p [m]
    travel  l [m]
    own     speed of its prototype's walk, 0 of one that does not walk [m/s]
    """

    bound: FloatArray
    reach: FloatArray
    walk: FloatArray
    planted: FloatArray
    travel: FloatArray
    own: FloatArray

    @staticmethod
    def of(prototypes: Sequence[RiggedPrototype]) -> "MotionBounds":
        """Collect them of the prototypes of bodies, one each."""
        rows = np.array([_bounds_of(each) for each in prototypes]).reshape(-1, 6)
        return MotionBounds(*rows.T)


@lru_cache(maxsize=256)
def _bounds_of(prototype: RiggedPrototype) -> tuple[float, ...]:
    motion, bound = prototype.motion, float(prototype.hierarchy.B[0])
    walking, resting = (stick_ends(each)[0] for each in (prototype, at_rest(prototype)))
    if walking.shape[1] == 0:
        return bound, reach_in_plan(prototype), 0.0, 0.0, 0.0, 0.0
    swung = float(np.hypot(walking[..., 0], walking[..., 1]).max())
    reach = max(reach_in_plan(prototype), swung)
    if motion.stride == 0:
        return bound, reach, 0.0, 0.0, 0.0, 0.0
    step = np.linalg.norm(np.roll(walking, -1, axis=0) - walking, axis=-1).max() * len(walking)
    travel = np.linalg.norm(walking - resting, axis=-1).max()
    ahead = max(abs(prints_ahead(motion, phase)) for phase in np.linspace(0, 1, 65).tolist())
    walk, planted = float(step) / motion.stride, float(step) * ahead
    return bound, reach, walk, planted, float(travel), motion.speed


@dataclass(frozen=True)
class Lens:
    """What a camera resolves: θ of a pixel [rad], and half its widest angle of view [rad].

    offscreen  share of the detail that is kept out of view
    """

    theta: float
    half_angle: float
    offscreen: float


def offset_bound_m(bodies: MotionBounds, speed: Reals, since_s: Reals) -> Reals:
    """Bound how far a part is from where coasting has it, (n,) [m]."""
    t, a, alpha = since_s, ACCELERATION, SPIN_ACCELERATION
    straight = a * t**2 / 2
    place = straight + speed * alpha * t**3 / 6
    turned = bodies.reach * np.minimum(alpha * t**2 / 2, 2.0)
    own = np.maximum(bodies.own, 1e-9)
    now, more = speed / own, a * t / own
    low, high = now - more, now + more
    # How steeply the cadence rises with speed at most: more where strides are as long as they get.
    rise = (1.0 - STRIDE_POWER) * np.maximum(low, SLOWEST) ** -STRIDE_POWER
    capped = high > LONGEST_STRIDE ** (1.0 / STRIDE_POWER)
    cadence = np.where(capped, np.maximum(rise, 1.0 / LONGEST_STRIDE), rise)
    walked = bodies.walk * cadence * straight
    stride = _stride(now)
    strides = np.maximum(stride - _stride(low), _stride(high) - stride)
    change = np.maximum(np.log(stride / _stride(low)), np.log(_stride(high) / stride))
    most = 2.0 * bodies.travel
    planted = np.where(low < SLOWEST, most, np.minimum(bodies.planted * change, most))
    blend = np.minimum(1.0, more / SLOWEST + 1.0 / EIGHTHS)
    shuffled = bodies.walk * own * SLOWEST ** (1.0 - STRIDE_POWER) * t
    slow = np.where(low < SLOWEST, bodies.travel * blend + shuffled, 0.0)
    # The knee of a nearly straight leg may move farther than its foot: seen, up to 1.45 times.
    stepped = walked + 1.5 * bodies.travel * strides + slow
    stepped += np.where(now > 0, planted, 0.0)
    return np.where(t > 0, place + turned + np.where(bodies.own > 0, stepped, 0.0), 0.0)


def _stride(relative: Reals) -> Reals:
    """Find the stride at a speed, both as shares of the prototype's own."""
    found: Reals = np.minimum(np.maximum(relative, SLOWEST) ** STRIDE_POWER, LONGEST_STRIDE)
    return found


def bound_px(
    bodies: MotionBounds, stand: Standings, now_s: float, eye: Eye, lens: Lens
) -> tuple[Reals, Reals]:
    """Bound by how much a part of each body is off on the image [px], and how urgent that is, (n,).

    Urgency is the same bound in view; out of view, where there are shadows alone, less.
    """
    if stand.held:  # what messages hold may reach anywhere within the bound
        reach, rows = bodies.reach.copy(), list(stand.held)
        reach[rows] = bodies.bound[rows]
        bodies = replace(bodies, reach=reach)
    off = offset_bound_m(bodies, stand.speed, now_s - stand.went)
    away = stand.places[:, (X, Y)] - np.array(eye[:2])
    d = np.maximum(np.hypot(*away.T) - bodies.bound, 0.1)
    px = off / d / lens.theta
    a = np.radians(eye.heading)
    ahead = away @ np.array((np.sin(a), np.cos(a)))
    apart = np.arccos(np.clip(ahead / np.maximum(np.hypot(*away.T), 1e-9), -1, 1))
    margin = np.arcsin(np.clip((bodies.bound + off) / (d + bodies.bound), 0, 1))
    seen = apart < lens.half_angle + margin
    return px, np.where(seen, px, px * lens.offscreen)


LONGEST_COAST_S = 1.0  # longest time between two updates [s]


@dataclass(frozen=True)
class Rules:
    """Which actors are updated in a frame.

    threshold  [px] beyond which an actor is updated; 0 = everyone in every frame
    budget     of updates in a frame; None = as many as are due
    """

    threshold: float = 0.0
    budget: int | None = None


class Acting:
    """A scene that acts: its stage, its processes and its clock.

    processes  of the actors by name, of those that have a behaviour; and of the camera
    cues       of the script, in their order
    path       where the preset has the camera in a frame
    rules      may be replaced between two frames
    """

    def __init__(
        self,
        stage: Stage,
        prototypes: Sequence[RiggedPrototype],
        processes: Mapping[str, Process],
        cues: Sequence[Process],
        rules: Rules,
        lens: Lens,
        path: Callable[[float], Eye],
        fps: float,
    ) -> None:
        self.stage, self._processes, self._cues = stage, processes, cues
        self.rules, self._lens, self._path, self._fps = rules, lens, path, fps
        self._names: tuple[str, ...] = stage.names()
        self._row = {name: row for row, name in enumerate(self._names)}
        self._acts = np.array([name in processes for name in self._names], bool)
        self._bodies = MotionBounds.of(prototypes)
        self._frame, self._now = 0, 0.0
        self._last = np.full(len(self._names), -math.inf)
        self._held: Held = {}
        self._updated: set[str] = set()
        self._depth = 0

    def act(self) -> ActedFrame:
        """Act the next frame. Raises InputError, in one line, for what goes wrong in it."""
        self._frame += 1
        self._now = (self._frame - 1) / self._fps
        self._updated = set()
        self._send(change("", "begin", self._now, self._path(self._frame)))
        for each in self._cues:
            each.update(self.stage, self._now, self._attend)
        for name in self._due():
            self._update(name)
        if CAMERA in self._processes:  # last: whom it follows has moved
            self._processes[CAMERA].update(self.stage, self._now, self._attend)
        stand: Standings = self._send(ask("", "standings"))
        moved = self._send(ask(CAMERA, "moved"))
        eye: Eye = self._send(ask(CAMERA, "eye"))
        self._held = stand.held
        updated = np.array([name in self._updated for name in self._names], bool)
        off = np.where(updated, 0.0, self._bounds(stand)[0])
        return ActedFrame(stand.places, updated, off, stand.held, eye if moved else None)

    def _due(self) -> list[str]:
        stand: Standings = self._send(ask("", "standings"))
        acts = self._acts & np.isfinite(stand.places[:, X])
        urgency = self._bounds(stand)[1]
        if self.rules.threshold == 0:
            order = np.flatnonzero(acts)
        else:
            due: Flags = acts & (urgency > self.rules.threshold)
            due |= acts & (self._now - self._last >= LONGEST_COAST_S - 1e-9)
            restless = [row for row, held in stand.held.items() if self._held.get(row) != held]
            due[restless] = acts[restless]
            order = np.flatnonzero(due)[np.argsort(-urgency[due], kind="stable")]
        return [self._names[row] for row in order[: self.rules.budget].tolist()]

    def _bounds(self, stand: Standings) -> tuple[Reals, Reals]:
        eye: Eye = self._send(ask(CAMERA, "eye"))
        px, urgency = bound_px(self._bodies, stand, self._now, eye, self._lens)
        return np.where(self._acts, np.nan_to_num(px), 0.0), np.nan_to_num(urgency)

    def _attend(self, name: str) -> None:
        """Bring whoever is asked up to date first, unless that one asks just now.

        So are 16 who are asked while they ask others; the next one coasts.
        """
        if name in self._row and self._depth < 16:
            self._update(name)

    def _update(self, name: str) -> None:
        if name in self._updated or name not in self._processes:
            return
        self._updated.add(name)
        self._last[self._row[name]] = self._now
        self._depth += 1
        try:
            self._processes[name].update(self.stage, self._now, self._attend)
        finally:
            self._depth -= 1

    def _send(self, message: Message):  # type: ignore[no-untyped-def]
        return self.stage.receive(message).value
