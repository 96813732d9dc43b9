"""How is one arm at one setting measured? Its frames are made and timed in turns with others."""

import time
import weakref
from dataclasses import dataclass, field, replace

from bench.methods.catalogue import arms
from bench.methods.comparison import STAGES
from bench.methods.method import Arm, Updater
from bench.records.records import Column, Point, columns
from bench.windows import Picture, window_preset
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.presets.schema import Preset
from scenes.render.render import BuiltFrame, build_frame, move_camera, render_frame, trace
from scenes.world.world import World, build_world

_BARE = "species.sward.density=0"
"""Trees and people are compared; blades of grass would be nearly all parts there are."""

KINDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "crowd": ("crowd", ("species.tree.density=0",)),
    "meadow": ("meadow", (_BARE,)),
    "swaying": ("meadow", (_BARE, "wind.speed=6")),
    "forest": ("forest", (_BARE,)),
    "swaying forest": ("forest", (_BARE, "wind.speed=6")),
    "from above": ("meadow", (_BARE, "camera.height=60", "camera.pitch=-20")),
}
"""For each kind of world its preset and what is changed in it."""


@dataclass(frozen=True)
class Window:
    """One field of one kind of world, and how its frames are measured.

    objects   mean number of objects in the window
    field     number of the field, added to the run's seed
    picture   size, and samples of each pixel
    pairs     pairs of sampler seeds by which errors are measured
    repeats   timed frames of each arm and setting
    variant   of the renderer
    arms      names of those that are tried; none = all
    weighed   settings of each arm whose memory is measured, of those that are timed
    """

    kind: str
    objects: float
    field: int
    picture: Picture
    pairs: int
    repeats: int
    variant: str
    arms: tuple[str, ...] = ()
    weighed: int = 1

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.kind}, {self.objects:g} objects, field {self.field + 1}"

    def preset(self, seed: int, *more: str) -> Preset:
        """Make the preset of the whole window, unpruned; ``more`` are other settings."""
        name, settings = KINDS[self.kind]
        words = (*settings, *more, f"seed={seed + self.field}")
        return window_preset(name, words, self.objects, self.picture, None)


@dataclass
class Runner:
    """One arm at one setting: its updater, what it built last, and what was measured.

    error     what its first frame is judged by (``judged_error``); NaN where it is not known
    times     by stage the microseconds of each timed frame
    """

    arm: Arm
    setting: float
    updater: Updater
    prepared: float = 0.0
    error: float = float("nan")
    made: FrameInput | None = None
    built: BuiltFrame | None = None
    columns: list[Column] = field(default_factory=list)
    statistics: dict[str, int] = field(default_factory=dict)
    times: dict[str, list[int]] = field(default_factory=dict)
    shown: list[weakref.ref] = field(default_factory=list)

    def frame(self, number: int, variant: str) -> None:
        """Make and build a frame."""
        made = self.updater(number, variant)
        self.built = self._moved(made) if self._is_shown(made) else build_frame(made)
        self._note(made)

    def timed_frame(self, number: int, variant: str) -> None:
        """Make, build and trace a frame, and note what each stage took.

        What the updater kept from the frame before is built anew first, which counts as
        preparation.
        """
        clock, cpu = time.perf_counter(), time.process_time()
        made = self.updater(number, variant)
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
        for stage in STAGES:
            self.times.setdefault(stage, []).append(round(1e6 * spent[stage]))
        self.times.setdefault("cpu", []).append(round(1e6 * used))
        self.times.setdefault("prepare", []).append(round(1e6 * prepared))

    def picture(self, seed: int) -> Layers:
        """Trace the frame that was made last. Raises RuntimeError where there is none."""
        if self.made is None or self.built is None:
            raise RuntimeError(f"{self.arm.name}: no frame was made")
        layers = trace(self.built, replace(self.made.quality, seed=seed))
        self.statistics = dict(layers.statistics)
        return layers

    def forget(self) -> None:
        """Free what was made and built; an updater may keep what it uses again."""
        self.made = self.built = None

    def point(self, **where: object) -> Point:
        """Return all that was measured as a point."""
        named = {"arm": self.arm.name, "setting": self.setting}
        drawn = columns({name: [count] for name, count in self.statistics.items()})
        times = (Column("us", row, {"stage": stage}) for stage, row in self.times.items())
        return Point({**where, **named}, samples=(*self.columns, *drawn, *times))

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


def prepared_runner(arm: Arm, setting: float, world: World, preset: Preset) -> Runner:
    """Prepare an arm at a setting, and note how long that takes."""
    start = time.perf_counter()
    updater = arm.prepare(world, preset, setting)
    return Runner(arm, setting, updater, time.perf_counter() - start)


def make_one_frame(window: Window, seed: int, arm: str, setting: float) -> None:
    """Make and trace the first frame of a window: in a fresh process, for its memory."""
    preset = window.preset(seed)
    updater = arms()[arm].prepare(build_world(preset), preset, setting)
    render_frame(updater(1, window.variant), 1)
