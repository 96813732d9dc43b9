"""Frames of one method at one setting in a window: made, built and timed in turns with others."""

import time
import weakref
from dataclasses import dataclass, field, replace

from bench.frame_costs import KINDS, Kind, Picture, window_preset
from bench.methods.known_methods import methods
from bench.methods.method import Method
from bench.records.records import Column, Point, columns
from bench.seeds import first_seed
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.render.render import BuiltFrame, build_frame, move_camera, render_frame, trace
from scenes.scene import Scene

STAGES = "update", "describe", "build", "trace"
"""The stages of a frame that are timed: pruned and posed, described, built, traced."""


@dataclass(frozen=True)
class Window:
    """One field of one kind of world, and how its frames are measured.

    objects   mean number of objects in the window
    field     number of the field, added to the run's seed
    pairs     pairs of sampler seeds by which errors are measured
    repeats   timed frames of each method and setting
    tried     names of the methods that are tried; none = all
    weighed   settings of each method whose memory is measured, of those next to equal error
    unseen    whether its worlds are those for judging, or may be looked at by anybody
    world     that of the kind where it is none of KINDS
    """

    kind: str
    objects: float
    field: int
    picture: Picture
    pairs: int
    repeats: int
    variant: str
    tried: tuple[str, ...] = ()
    weighed: int = 1
    unseen: bool = False
    world: Kind | None = None

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.kind}, {self.objects:g} objects, field {self.field + 1}"

    def scene(self, seed: int, *more: str) -> Scene:
        """Make the scene of the window, unpruned; ``more`` are other settings."""
        name, settings = self.world or KINDS[self.kind]
        own = first_seed(self.unseen, 9) + 20 * seed + self.field
        words = (*settings, *more, f"seed={own}")
        return Scene(window_preset(name, words, self.objects, self.picture, None))


@dataclass
class Runner:
    """One method at one setting, prepared, with what it built last and what was measured.

    prepared  seconds that preparing took
    error     what its first frame is judged by (``judged_error``); NaN where it is not known
    times     by stage the microseconds of each timed frame
    """

    method: Method
    setting: float
    scene: Scene
    prepared: float = field(init=False)
    error: float = float("nan")
    made: FrameInput | None = None
    built: BuiltFrame | None = None
    columns: list[Column] = field(default_factory=list)
    statistics: dict[str, int] = field(default_factory=dict)
    times: dict[str, list[int]] = field(default_factory=dict)
    shown: list[weakref.ref] = field(default_factory=list)

    def __post_init__(self) -> None:
        _ = self.scene.world  # which is no part of the preparation
        start = time.perf_counter()
        self.update = self.method.prepare(self.scene, self.setting)
        self.prepared = time.perf_counter() - start

    def frame(self, number: int, variant: str) -> None:
        """Make and build a frame."""
        made = self.update(number, variant)
        self.built = self._moved(made) if self._is_shown(made) else build_frame(made)
        self._note(made)

    def timed_frame(self, number: int, variant: str) -> None:
        """Make, build and trace a frame, and note what each stage took.

        What the updater kept from the frame before is built again first, which counts as
        preparation.
        """
        clock, cpu = time.perf_counter(), time.process_time()
        made = self.update(number, variant)
        spent, used = {"update": time.perf_counter() - clock}, time.process_time() - cpu
        still, prepared = self._is_shown(made), self.prepared
        if still and self.built is None:
            clock = time.perf_counter()
            self.built = build_frame(made)
            prepared += time.perf_counter() - clock
        cpu = time.process_time()
        self.built = self._moved(made) if still else build_frame(made)
        self._note(made)
        layers = trace(self.built, made.quality)
        used += time.process_time() - cpu
        spent |= {**self.built.seconds, "trace": layers.seconds["trace"]}
        rows = {**{stage: spent[stage] for stage in STAGES}, "cpu": used, "prepare": prepared}
        for stage, seconds in rows.items():
            self.times.setdefault(stage, []).append(round(1e6 * seconds))

    @property
    def last_s(self) -> float:
        """Seconds that the last timed frame took; 0 before there is one."""
        return sum(self.times[stage][-1] for stage in STAGES) / 1e6 if self.times else 0.0

    def picture(self, seed: int) -> Layers:
        """Trace the frame that was made last. Raises RuntimeError where there is none."""
        if self.made is None or self.built is None:
            raise RuntimeError(f"{self.method.name}: no frame was made")
        layers = trace(self.built, replace(self.made.quality, seed=seed))
        self.statistics = dict(layers.statistics)
        return layers

    def forget(self) -> None:
        """Free what was made and built; an updater may keep what it uses again."""
        self.made = self.built = None

    def point(self, **where: object) -> Point:
        """Return all that was measured as a point."""
        named = {"topic": "rivals", **where, "arm": self.method.name, "setting": self.setting}
        drawn = columns({name: [count] for name, count in self.statistics.items()})
        times = (Column("us", row, {"stage": stage}) for stage, row in self.times.items())
        return Point(named, samples=(*self.columns, *drawn, *times))

    def _moved(self, made: FrameInput) -> BuiltFrame:
        return move_camera(self.built or build_frame(made), made.camera, made.air)

    def _is_shown(self, made: FrameInput) -> bool:
        """Tell whether everything displayed is the very same as in the frame before."""
        before = [each() for each in self.shown]
        return len(before) == len(made.displayed) and all(
            one is two for one, two in zip(before, made.displayed, strict=True)
        )

    def _note(self, made: FrameInput) -> None:
        self.made, self.shown = made, [weakref.ref(each) for each in made.displayed]


def make_one_frame(window: Window, seed: int, method: str, setting: float) -> None:
    """Make and trace the first frame of a window: in a fresh process, for its memory."""
    updater = methods()[method].prepare(window.scene(seed), setting)
    render_frame(updater(1, window.variant), 1)
