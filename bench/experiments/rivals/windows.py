"""Which worlds are looked at, and how?"""

from dataclasses import dataclass

from bench.arms.registry import arms
from bench.fields.windows import Picture, window_preset
from bench.outside.environments import CYCLES
from bench.records.points import Point
from bench.records.provenance import scene_digest
from bench.runner.experiment import Effort
from scenes.preset.load import load_preset
from scenes.preset.tables import Preset
from scenes.render.mitsuba.variants import choose

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

JUDGED = "blake", "clipped", "discrete", "stochastic"
"""The arms whose sequences ColorVideoVDP judges."""


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


@dataclass(frozen=True)
class Walk:
    """A sequence of ``frames`` frames through a window, in which motion is looked at."""

    window: Window
    frames: int

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.frames} frames of {self.window.label}"


@dataclass(frozen=True)
class OtherRenderer:
    """A window that Cycles renders, too: whole, and cut by the metric."""

    window: Window

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"Cycles, {self.window.label}"


Case = Window | Walk | OtherRenderer


def cases(effort: Effort) -> list[Case]:
    """Return every field of every world, the walk, and what Cycles renders if it is here."""
    variant = choose()
    common = {name: effort[name] for name in ("pairs", "repeats", "weighed")}
    picture = Picture(effort["size"], effort["spp"])
    windows = [
        Window(kind, objects, field, picture, variant=variant, arms=tuple(few), **common)
        for kind, objects, fields, few in effort["worlds"]
        for field in range(fields)
    ]
    kind, objects, size, frames = effort["walk"]
    small = Window(kind, objects, 0, Picture(size, effort["spp"]), 2, 1, variant)
    walk = Walk(small, frames)
    others = [OtherRenderer(w) for w in windows if [w.kind, w.objects] in effort["cycles"]]
    return [*windows, walk, *(others if CYCLES.python() else [])]


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the kinds of worlds, and of the arms with their settings."""
    tried = {name: arm.settings for name, arm in arms().items()}
    worlds = sorted({(p.case["kind"], p.case["objects"]) for p in points})
    presets = [load_preset(*KINDS[kind]).model_dump(mode="json") for kind, _ in worlds]
    return scene_digest([KINDS, worlds, tried, presets])
