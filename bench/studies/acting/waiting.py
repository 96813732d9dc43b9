"""How many seconds the temporal metric saves where actors act, and how far off those are who wait.

A crowd acts twice, everyone updated in every frame and by a threshold, timed frame by frame in
turns (processor time, without pruner and renderer). Errors are of every displayed part, against
the same scene on a copy of its state (a forked process) in which all are brought up to date: at
that frame alone, and in all of the ``COPIED`` frames up to it, which is longer than anybody waits.
"""

import multiprocessing
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.studies.acting.crowd import dearer, troupe_of, walkers
from lod.arrays import Reals
from lod.crossfade import blend_weights
from lod.pruner import prune
from lod.shapes import Sticks
from lod.update_schedule import TruePose, displacement_px, initial_state
from lod.view import View
from scenes.actors.acting import LONGEST_COAST_S, Acting, Rules
from scenes.actors.performance import ActedFrame, Cast, Performance
from scenes.world.view import view_at
from scenes.world.world import build_world

COPIED = round(24 * LONGEST_COAST_S)
"""Frames for which the copy is kept up to date."""

AIM_TIMES, AIM_PX = 3.0, 0.5
"""How many times fewer seconds are aimed at, and at which error, its 99.9th percentile."""


@dataclass(frozen=True)
class Crowd:
    """Who acts: walkers, how many of them on a square metre, and questions on top of theirs.

    threshold  of the bound beyond which an actor is updated [px]
    waving     whether they wave as often as is shipped, or never
    """

    actors: int
    density: float = 0.005
    questions: int = 0
    threshold: float = 0.5
    waving: bool = False


@dataclass(frozen=True)
class Saving:
    """What a threshold saves.

    seconds_all, seconds_some  processor time of updating all, and those that are due
    updated      share of all possible updates
    at_once_px   how far a displayed part is off, against one updated at that frame: the 99.9th
                 percentile and the largest [px]
    in_time_px   the same against one updated in every frame for as long as anybody waits
    parts_ratio  parts displayed, some ÷ all
    """

    crowd: Crowd
    seconds_all: float
    seconds_some: float
    updated: float
    at_once_px: tuple[float, float]
    in_time_px: tuple[float, float]
    parts_ratio: float

    @property
    def saved(self) -> float:
        """Return how many times fewer seconds it takes."""
        return self.seconds_all / self.seconds_some


def saving(crowd: Crowd, frames: int, seed: int, looks: int = 4) -> Saving:
    """Let a crowd act in both ways, and compare; errors are looked at in so many frames."""
    side = float(np.sqrt(crowd.actors / crowd.density))
    presets = [
        walkers(crowd.actors, side, frames, each, seed, crowd.waving)
        for each in (0.0, crowd.threshold)
    ]
    with dearer(crowd.questions):
        every, some = (troupe_of(each) for each in presets)
    world, spent, updates = build_world(presets[1]), np.zeros((2, frames)), 0
    copies: dict[int, list[ActedFrame]] = {}
    off: tuple[list[Reals], list[Reals]] = ([], [])
    parts, times = np.zeros(2), np.linspace(min(COPIED, frames), frames, looks).astype(int).tolist()
    for frame in range(1, frames + 1):
        for last in times:
            if frame == max(1, last - COPIED + 1):
                copies[last] = acted_on_a_copy(some.acting, last - frame + 1)
        at_once = acted_on_a_copy(some.acting, 1) if frame in times else []
        for way, troupe in enumerate((every, some)):
            start = time.process_time()
            troupe.cast.performance.frame(frame)
            spent[way, frame - 1] = time.process_time() - start
        updates += int(some.cast.performance.frame(frame).updated.sum())
        if frame in times:
            view = view_at(world, presets[1], frame)
            for found, acted in zip(off, (at_once, copies.pop(frame)), strict=True):
                found.append(off_px(some.cast, acted[-1], view, frame))
            parts += [len(prune(each.cast, view)) for each in (every, some)]
    all_s, some_s = spent[:, 1:].sum(axis=1).tolist()  # compiling falls into the first
    at_once_px, in_time_px = (_worst(np.concatenate(found)) for found in off)
    share = updates / (crowd.actors * frames)
    return Saving(
        crowd, all_s, some_s, share, at_once_px, in_time_px, float(parts[1] / max(parts[0], 1))
    )


def acted_on_a_copy(acting: Acting, frames: int) -> list[ActedFrame]:
    """Act the next frames on a copy of a scene as it is now, everyone updated in each of them.

    Generators cannot be copied; a process that forks has them all.
    """
    forking = multiprocessing.get_context("fork")
    mine, theirs = forking.Pipe(duplex=False)
    child = forking.Process(target=_act_all, args=(acting, frames, theirs))
    child.start()
    theirs.close()
    acted: list[ActedFrame] = mine.recv()
    child.join()
    return acted


def _act_all(acting: Acting, frames: int, answers: "multiprocessing.connection.Connection") -> None:
    acting.rules = Rules()
    answers.send([acting.act() for _ in range(frames)])


def off_px(shown: Cast, acted: ActedFrame, view: View, frame: int) -> Reals:
    """Compute how far each displayed part of a cast is from where it has acted to, (p,) [px]."""
    names = shown.performance.names
    there = replace(shown, performance=Performance(names, [acted] * (frame + 1), None, frame))
    return sticks_off_px(shown, there, view)


def sticks_off_px(shown: Cast, true: Cast, view: View) -> Reals:
    """Compute how far each displayed part of one cast is from where another has it, (p,) [px]."""
    cut = prune(shown, view)
    weights = blend_weights(cut, view)
    there = true.later(cut.parts, view, view.time_s)
    before, now = (
        _pose(cast.appearance(parts, weights), len(cut), view)
        for cast, parts in ((shown, cut.parts), (true, there))
    )
    return displacement_px(initial_state(before), now)


def _pose(sticks: Sticks, parts: int, view: View) -> TruePose:
    due = np.zeros(parts, bool)
    return TruePose(sticks.start, sticks.end, sticks.owner, due, view.camera.eye, view.theta)


def _worst(off: Reals) -> tuple[float, float]:
    return float(np.quantile(off, 0.999)), float(off.max())


def saving_rows(found: Sequence[Saving]) -> list[tuple[str, ...]]:
    """Write savings as the rows of a table, its head first."""
    who = "actors", "a m²", "waving", "questions more", "bound px"
    head = (*who, "s, all", "s, some", "saved", "updated")
    px = "at once p99.9", "most px", "in time p99.9", "most px"
    rows: list[tuple[str, ...]] = [(*head, *px, "parts")]
    for each in found:
        crowd = each.crowd
        who = (
            f"{crowd.actors:,}",
            f"{crowd.density:g}",
            "yes" if crowd.waving else "no",
            str(crowd.questions),
            f"{crowd.threshold:g}",
        )
        seconds = f"{each.seconds_all:.1f}", f"{each.seconds_some:.1f}", f"{each.saved:.2f}"
        off = (f"{px:.3f}" for px in (*each.at_once_px, *each.in_time_px))
        rows.append((*who, *seconds, f"{each.updated:.3f}", *off, f"{each.parts_ratio:.4f}"))
    return rows


def verdict_rows(found: Sequence[Saving]) -> list[str]:
    """Judge the aim by either error: of each crowd, the bound that saves most within ``AIM_PX``."""
    crowds: dict[Crowd, list[Saving]] = {}
    for each in found:
        crowds.setdefault(replace(each.crowd, threshold=0.0), []).append(each)
    lines = [
        f"aim: {AIM_TIMES:g} times fewer seconds while 99.9 % of the displayed parts are off by at"
        f" most {AIM_PX:g} px"
    ]
    for crowd, savings in crowds.items():
        more = f", {crowd.questions} questions more" if crowd.questions else ""
        waving = ", waving" if crowd.waving else ""
        lines.append(f"{crowd.actors:,} actors, {crowd.density:g} a m²{more}{waving}:")
        for error in ("at_once_px", "in_time_px"):
            name = error.removesuffix("_px").replace("_", " ")
            lines.append(f"  {name}: {_verdict(savings, error)}")
    return lines


def _verdict(savings: Sequence[Saving], error: str) -> str:
    """Tell whether any of the savings of a crowd reaches the aim by an error."""
    bounds = ", ".join(f"{each.crowd.threshold:g}" for each in savings)
    tried = f"at {'any' if len(savings) > 1 else 'the'} bound tried ({bounds} px)"
    within = [each for each in savings if getattr(each, error)[0] <= AIM_PX]
    if not within:
        least = min(getattr(each, error)[0] for each in savings)
        return f"not reached {tried}: {least:.3f} px off or more"
    best = max(within, key=lambda each: each.saved)
    high, most = getattr(best, error)
    off = f"({high:.3f} px off, most {most:.3f})"
    at = f"{best.saved:.2f} times at a bound of {best.crowd.threshold:g} px {off}"
    return f"reached: {at}" if best.saved >= AIM_TIMES else f"not reached {tried}: {at}"
