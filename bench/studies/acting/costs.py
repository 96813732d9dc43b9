"""Where the time of an actor's update goes: quaternions, messages, the behaviour, and the pruner.

The processor's clock interrupts the acting every 0.5 ms (ITIMER_PROF), and the module is noted
whose code runs then; what a library does counts for whoever called it. Shares of the notes times
the time of an update, which is measured without interruptions, are the split.
"""

import math
import signal
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType

from bench.studies.acting.crowd import Troupe, by_behaviour, troupe_of, walkers
from lod.crossfade import blend_weights
from lod.pruner import prune
from scenes.preset.tables import Preset
from scenes.world.view import view_at
from scenes.world.world import build_world

_EVERY_S = 0.0005
KINDS: dict[str, tuple[str, ...]] = {
    "quaternions": ("lod.actors.quaternion", "lod.actors.joint", "lod.actors.quaternion"),
    "messages": ("lod.actors",),
    "bodies": ("scenes.actors.body", "scenes.actors.limb", "scenes.actors.limb"),
    "the scene": ("scenes.actors.stage",),
    "behaviours": ("scenes.actors.behaviours",),
    "who is due": ("scenes.actors",),
}
"""What the modules of each name are; the first that fits counts."""


WITHOUT_WAVING = "walk without waving"


@dataclass(frozen=True)
class Costs:
    """Microseconds of an update of an actor, and of the pruner a frame for each actor.

    split  the update's, by kind
    who    what they do
    """

    actors: int
    side_m: float
    update_us: float
    split: dict[str, float]
    prune_us: float
    who: str = WITHOUT_WAVING


@dataclass(frozen=True)
class ByBehaviour:
    """What an update costs by what an actor does, measured in turns."""

    found: list[Costs]


def costs(count: int, side: float, frames: int, seed: int) -> Costs:
    """Measure a crowd in a square, all updated in every frame."""
    preset = walkers(count, side, 3 * frames, 0.0, seed)
    return _in_turns({WITHOUT_WAVING: preset}, side, frames)[0]


def costs_by_behaviour(count: int, side: float, frames: int, seed: int) -> ByBehaviour:
    """Measure actors of every shipped behaviour of bodies, which take turns frame by frame."""
    return ByBehaviour(_in_turns(by_behaviour(count, side, 3 * frames, seed), side, frames))


def _in_turns(presets: Mapping[str, Preset], side: float, frames: int) -> list[Costs]:
    """Time and then sample troupes, each all updated in every frame."""
    troupes = {who: troupe_of(preset) for who, preset in presets.items()}
    seconds, notes = dict.fromkeys(troupes, 0.0), {}
    for frame in range(1, 2 * frames + 1):
        for who, troupe in troupes.items():
            spent = _act(troupe, frame, frame)
            seconds[who] += spent if frame > frames else 0.0  # compiling falls into the first
    for who, troupe in troupes.items():
        with sampled() as notes[who]:
            _act(troupe, 2 * frames + 1, 3 * frames)
    found = []
    for who, troupe in troupes.items():
        count, total = len(troupe.cast.prototypes), max(sum(notes[who].values()), 1)
        whole = 1e6 * seconds[who] / (count * frames)
        split = {kind: whole * notes[who][kind] / total for kind in (*KINDS, "else")}
        prune_us = 1e6 * _prune_s(troupe, presets[who]) / count
        found.append(Costs(count, side, whole, split, prune_us, who))
    return found


def _act(troupe: Troupe, first: int, last: int) -> float:
    start = time.process_time()
    for frame in range(first, last + 1):
        troupe.cast.performance.frame(frame)
    return time.process_time() - start


def _prune_s(troupe: Troupe, preset: Preset) -> float:
    """Time finding, blending and posing what is displayed in the last frame, the least of three."""
    view = view_at(build_world(preset), preset, preset.acting.frames)
    least = math.inf
    for _ in range(4):  # the first one compiles
        start = time.process_time()
        cut = prune(troupe.cast, view)
        troupe.cast.appearance(cut.parts, blend_weights(cut, view))
        least = min(least, time.process_time() - start)
    return least


@contextmanager
def sampled() -> Iterator[Counter[str]]:
    """Count, while it runs, whose code the processor's clock finds."""
    notes: Counter[str] = Counter()

    def note(number: int, frame: FrameType | None) -> None:
        notes[kind_of(frame)] += 1

    before = signal.signal(signal.SIGPROF, note)
    signal.setitimer(signal.ITIMER_PROF, _EVERY_S, _EVERY_S)
    try:
        yield notes
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def kind_of(frame: FrameType | None) -> str:
    """Tell which kind of work runs in a frame of the stack: of the innermost code of ours."""
    while frame is not None:
        name = frame.f_globals.get("__name__", "")
        for kind, modules in KINDS.items():
            if name.startswith(modules):
                return kind
        frame = frame.f_back
    return "else"


def cost_rows(found: list[Costs]) -> list[tuple[str, ...]]:
    """Write costs as the rows of a table, its head first [µs]."""
    head = "who", "actors", "in a square of", "an update", *KINDS, "else", "pruner, a frame"
    rows: list[tuple[str, ...]] = [head]
    for each in found:
        split = (f"{us:.0f}" for us in each.split.values())
        who = each.who, str(each.actors), f"{each.side_m:.0f} m"
        rows.append((*who, f"{each.update_us:.0f}", *split, f"{each.prune_us:.1f}"))
    return rows
