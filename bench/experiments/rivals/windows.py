"""Which worlds are looked at, and how?"""

from dataclasses import dataclass

from bench.arms.registry import arms
from bench.fields.windows import Picture, window_preset
from bench.records.points import Point
from bench.records.provenance import scene_digest
from bench.runner.experiment import Effort
from scenes.preset.load import load_preset
from scenes.preset.tables import Preset
from scenes.render.mitsuba.variants import choose

KINDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "crowd": ("crowd", ("species.tree.density=0",)),
    "meadow": ("meadow", ("species.sward.density=0",)),
    "swaying": (
        "meadow",
        (
            "species.sward.density=0",
            "wind.speed=6",
        ),
    ),
    "forest": ("forest", ("species.sward.density=0",)),
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
    """

    kind: str
    objects: float
    field: int
    picture: Picture
    pairs: int
    repeats: int
    variant: str

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.kind}, {self.objects:g} objects, field {self.field + 1}"

    def preset(self, seed: int) -> Preset:
        """Make the preset of the whole window, unpruned."""
        name, settings = KINDS[self.kind]
        words = (*settings, f"seed={seed + self.field}")
        return window_preset(name, words, self.objects, self.picture, None)


def cases(effort: Effort) -> list[Window]:
    """Return every field of every kind and size of world."""
    picture, variant = Picture(effort["size"], effort["spp"]), choose()
    return [
        Window(kind, objects, field, picture, effort["pairs"], effort["repeats"], variant)
        for kind in effort["kinds"]
        for objects in effort["objects"]
        for field in range(effort["fields"])
    ]


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the kinds of worlds, and of the arms with their settings."""
    tried = {name: arm.settings for name, arm in arms().items()}
    worlds = sorted({(p.case["kind"], p.case["objects"]) for p in points})
    presets = [load_preset(*KINDS[kind]).model_dump(mode="json") for kind, _ in worlds]
    return scene_digest([KINDS, worlds, tried, presets])
