"""The scene as a whole whose parts are its actors: every message among them passes through it.

A part is asked by a route that begins with its name, as ``joe/right arm/hand``. The scene brings
whoever is asked up to date first, and answers in the place of its parts where they are in space:
only it knows the ground.
"""

import difflib
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from lod.actors.actor import Vector
from lod.actors.object_with_parts import (
    Action,
    Message,
    ObjectWithParts,
    Refusal,
    Refused,
    Route,
    ask,
    change,
    mutator,
    parse_route,
    query,
)
from scenes.actors.body import Body, CameraBody, Posture
from scenes.actors.performance import PHASE, YAW, Eye, Held, X, Y

CAMERA = "camera"  # name of the camera among the actors
Height = Callable[[float, float], float]  # height of the ground at a place [m]

_GONE = (np.nan,) * 10
_SPEED, _SPIN, _CADENCE, _WENT, _TIME = range(6, 11)


class Standings(NamedTuple):
    """How the bodies stand at a time: ``places`` (n, 6) and ``held`` as in ActedFrame.

    speed, went  (n,) how fast each goes [m/s], and when it was last told to [s]
    """

    places: np.ndarray
    speed: np.ndarray
    went: np.ndarray
    held: Held


class Stage(ObjectWithParts):
    """A scene of bodies and a camera."""

    def __init__(
        self, bodies: Mapping[str, Body], camera: CameraBody, height: Height, wind_deg: float = 90.0
    ) -> None:
        """Assemble the scene; the order of the bodies is that of their numbers.

        wind_deg  where the wind blows to, clockwise from north [degrees]
        """
        parts: dict[str, ObjectWithParts] = {**bodies, CAMERA: camera}
        super().__init__(parts, {name: type(part) for name, part in parts.items()}, "scene")
        self._rows = {name: row for row, name in enumerate(bodies)}
        self._height, self._time, self._wind_deg = height, 0.0, wind_deg
        self._known = np.zeros((len(bodies), 11))
        self._held: Held = {}
        self._stale = set(bodies)
        self._up_to_date = set[str]()
        self._names = tuple(bodies)
        self._tree: cKDTree | None = None

    @query
    def time(self) -> float:
        """Return the time of the scene [s]; frame 1 is at 0."""
        return self._time

    @query
    def wind(self) -> float:
        """Return where the wind blows to, clockwise from north [degrees]."""
        return self._wind_deg

    @query
    def names(self) -> tuple[str, ...]:
        """Return the names of the bodies."""
        return self._names

    @mutator
    def begin(self, time_s: float, on_path: Eye) -> None:
        """Begin a moment: its time [s], and where the preset has the camera."""
        self._time, self._tree, self._up_to_date = time_s, None, set()
        self._ask_part(change((CAMERA,), "follow_path", on_path))

    @query
    def where(self, route: Route | str) -> Vector:
        """Return where a part is: x, y [m], and its height above the datum [m]."""
        name, *below = parse_route(route) or ("",)
        self._look_up(name)
        if name == CAMERA:
            x, y, z = self._ask_part(ask((name,), "position"))
        else:
            x, y, z = self._ask_part(ask((name,), "where", tuple(below)))
        if name == CAMERA or below:
            ground = self._ask_part(ask((name,), "position"))
            return x, y, z + self._height(*ground[:2])
        return x, y, self._height(x, y)

    @query
    def near(self, name: str, radius: float) -> tuple[str, ...]:
        """Return the names of the bodies within a radius of one [m], the nearest first."""
        self._look_up(name)
        if self._tree is None:
            places = self.standings().places[:, (X, Y)]
            # Who has left is farther away than anyone looks.
            self._tree = cKDTree(np.where(np.isfinite(places), places, 1e18))
        row, known, xy = self._rows[name], self.names(), self._tree.data
        inside = np.sort(np.array(self._tree.query_ball_point(xy[row], radius), np.int64))
        away = np.hypot(*(xy[inside] - xy[row]).T)
        order = inside[np.argsort(away, kind="stable")].tolist()
        return tuple(known[other] for other in order if other != row)

    def intercept(self, message: Message) -> Message | Refusal:
        """Bring whoever is asked up to date, and answer where parts are."""
        name = message.route[0]
        self._look_up(name, kept=not message.action.changes)
        if message.action.name == "where" and not message.action.changes:
            return Message((), Action("where", (message.route,)))
        if message.action.changes and name != CAMERA:
            self._stale.add(name)
            if message.action.name in ("place", "leave"):
                self._tree = None
        return message

    def _look_up(self, name: str, kept: bool = True) -> None:
        """Bring a part up to date. Raises Refused where there is none of that name.

        kept  whether it stays so; not for a change, which may be refused and then takes it back
        """
        if name == CAMERA or name in self._up_to_date:
            return
        if name not in self._rows:
            known = [*self._rows, CAMERA]
            nearest = difflib.get_close_matches(name, known, 1, 0.0)[0]
            why = f"has no part {name!r}; the nearest known route is {nearest!r}"
            raise Refused(str(self), why)
        if self._known[self._rows[name], _TIME] < self._time:
            self._stale.add(name)
            self._ask_part(change((name,), "advance", self._time))
        if kept:
            self._up_to_date.add(name)

    @query
    def standings(self) -> Standings:
        """Return how all bodies stand now: asks those that have changed, and lets others coast."""
        for name in sorted(self._stale, key=self._rows.__getitem__):
            row = self._rows[name]
            if name not in self._up_to_date:
                self._ask_part(change((name,), "advance", self._time))
            stands: Posture | None = self._ask_part(ask((name,), "posture"))
            self._known[row] = (*(stands[:10] if stands else _GONE), self._time)
            self._held.pop(row, None)
            if stands and stands.held:
                self._held[row] = stands.held
        self._stale = set()
        known = self._known
        dt = self._time - known[:, _TIME]
        half = known[:, _SPIN] * dt / 2
        chord = known[:, _SPEED] * dt * np.sinc(half / np.pi)
        places = known[:, :6].copy()
        places[:, X] += chord * np.cos(known[:, YAW] + half)
        places[:, Y] += chord * np.sin(known[:, YAW] + half)
        places[:, YAW] += 2 * half
        places[:, PHASE] = (known[:, PHASE] + dt * known[:, _CADENCE]) % 1.0
        return Standings(places, known[:, _SPEED].copy(), known[:, _WENT].copy(), dict(self._held))
