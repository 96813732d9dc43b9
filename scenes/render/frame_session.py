"""Frames of one preset, from its settings to files: the way in which every process renders them."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from lod.errors import InputError
from scenes.actors.performance import (
    Performance,
    Track,
    from_bytes,
    performance_of,
    to_bytes,
    track_of,
)
from scenes.files import make_folder, whole_file
from scenes.frame.layers import Layers
from scenes.presets.load import has_acting
from scenes.presets.schema import Preset
from scenes.processes.memory_limit import peak_rss_bytes
from scenes.render.description import describe_frame
from scenes.render.exr.frames_on_disk import settings_hash
from scenes.render.exr.header import (
    Record,
    Settings,
    frame_header,
    picture_windows,
    preset_from_settings,
    software,
)
from scenes.render.exr.layer_file import with_mattes, write_exr
from scenes.render.memory import preflight
from scenes.render.object_keys import identities_in
from scenes.render.render import render_frame
from scenes.render.worker import ignore
from scenes.scene import Scene, make_terrain
from scenes.world.cast import make_cast

_ACTS = ("seed", "camera", "world", "wind", "terrain", "actors", "troupes", "acting", "script")
"""Tables of a preset on which it depends what actors do, beside the angles that are seen."""


def prepare_track(preset: Preset, folder: str | Path) -> str | None:
    """See that the track of a preset lies in a folder; give its hash, None where nobody acts.

    A whole one is kept; another is made by acting all frames. Raises InputError, in one line, for
    what an actor, a script or a behaviour does that cannot be.
    """
    if not has_acting(preset):
        return None
    path = track_path(preset, make_folder(folder))
    track = read_track(path)
    if track is None:
        track = _acted(preset)
        with whole_file(path, overwrite=True) as partial:
            partial.write_bytes(to_bytes(track))
    return track.digest


def check_acted(preset: Preset, frames: Sequence[int], most_bytes: int | None = None) -> None:
    """Raise InputError for a frame in which the actors of a preset do not act.

    And where all that they do is estimated to need more memory than it may (``preflight``).
    """
    most = preset.acting.frames
    if has_acting(preset) and max(frames) > most:
        rule = f"the actors act in frames 1 to {most}"
        raise InputError("--frames", max(frames), rule, f"add -D acting.frames={max(frames)}")
    preflight(Scene(preset), (), most_bytes, acted=most + 1)


def track_path(preset: Preset, folder: Path) -> Path:
    """Name the track's file by all that it depends on."""
    data = preset.model_dump(mode="json")
    view = {name: data["view"][name] for name in ("offscreen_detail", "look_around")}
    asked: dict[str, Any] = {name: data[name] for name in _ACTS}
    asked |= {"view": view, "size": data["render"]["size"], "software": software()}
    return folder / f"actors-{settings_hash(asked)[:16]}.npz"


def read_track(path: Path) -> Track | None:
    """Read a track; None where none lies there that is whole."""
    try:
        return from_bytes(path.read_bytes())
    except (OSError, ValueError):
        return None


def replayed(preset: Preset, digest: str, folder: Path) -> Performance:
    """Return what the actors of a preset do, by the track of that hash in a folder.

    Where it is not there any more they act again. Raises InputError where that gives another hash.
    """
    track = read_track(track_path(preset, folder))
    if track is None or track.digest != digest:
        track = _acted(preset)
    if track.digest != digest:
        rule = f"a track with the hash {digest[:16]}…, as the frames' settings have it"
        raise InputError("actors", f"{track.digest[:16]}…", rule, "render them anew: --overwrite")
    return performance_of(track)


def _acted(preset: Preset) -> Track:
    return track_of(make_cast(preset, make_terrain(preset)).performance)


Watch = Callable[[int, int], object]
"""Called with the samples of a frame taken so far, and how many there will be."""


class FrameSession:
    """Renders frames of one preset in this process; its world stays from frame to frame.

    settings  of ``frame_settings``, checked here. Raises InputError for what no preset can be
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self._preset = preset_from_settings(settings)
        self._folder: Path | None = None
        self._estimated: set[int] = set()

    @cached_property
    def _scene(self) -> Scene:
        track = self.settings.get("track")
        if track is None or self._folder is None:
            return Scene(self._preset)
        return Scene(self._preset, partial(replayed, self._preset, track, self._folder))

    def preflight(
        self, frames: Sequence[int], folder: str | Path | None, most_bytes: int | None = None
    ) -> Record:
        """Estimate the memory of frames whose files will lie in ``folder``; the record is empty.

        Raises InputError for the first that is estimated to need more than ``most_bytes`` allow.
        """
        self._folder = Path(folder) if folder else self._folder
        if new := [each for each in frames if each not in self._estimated]:
            acted = self._preset.acting.frames + 1
            preflight(self._scene, new, most_bytes, self._preset.render.variant, acted)
            self._estimated.update(new)
        return {}

    def render(
        self, frame: int, target: str | Path, watch: Watch = ignore, most_bytes: int | None = None
    ) -> Record:
        """Render a frame into ``target``, a file that does not exist yet.

        Record: frame, sha256 of the file, seconds {stage: s}, peak_rss_bytes, statistics. Building
        the world counts as the first frame's time. Raises as ``render_layers`` does, and OSError
        where the disk refuses.
        """
        self._folder = Path(target).parent  # where the track of its actors lies
        layers = self.render_layers(frame, watch, most_bytes)
        start = time.perf_counter()
        digest = write_exr(target, layers, self.header(frame), self._preset.output)
        write = time.perf_counter() - start
        return {
            "frame": frame,
            "sha256": digest,
            "seconds": {**layers.seconds, "write": write},
            "peak_rss_bytes": peak_rss_bytes(),
            "statistics": layers.statistics,
        }

    def render_layers(
        self, frame: int, watch: Watch = ignore, most_bytes: int | None = None
    ) -> Layers:
        """Render a frame into arrays, with the seconds and counts of every stage.

        ``watch`` is called with the samples taken so far, and how many there will be. Raises
        InputError for a frame that cannot be or would need more memory than ``most_bytes`` allow
        (``memory_limit``).
        """
        preset, start = self._preset, time.perf_counter()
        self.preflight((frame,), None, most_bytes)
        scene, world = self._scene, self._scene.world
        seconds = {"world": time.perf_counter() - start}
        frame_input = scene.input(frame, preset.render.variant)
        seconds |= frame_input.seconds
        description, cuts = None, [each.cut for each in frame_input.displayed]
        found = list(identities_in(world, cuts)) if preset.output.cryptomatte else []
        del cuts
        if not frame_input.subframes:
            start = time.perf_counter()
            description = describe_frame(frame_input)
            seconds["describe"] = time.perf_counter() - start
            frame_input = replace(frame_input, displayed=())  # or it would be held twice
        camera, quality = frame_input.camera, frame_input.quality
        samples = math.prod(quality.window_of((camera.width, camera.height)).size) * quality.spp
        samples *= 2 if camera.baseline_m else 1
        taken = 0

        def count(more: int) -> None:
            nonlocal taken
            taken += more
            watch(taken, samples)

        # Its memory was estimated before it was pruned.
        layers = render_frame(frame_input, frame, count, description, most_bytes=0)
        if layers.coverage:
            layers = with_mattes(layers, {each.object: (each.name, each.of) for each in found})
        return replace(
            layers,
            seconds=seconds | layers.seconds,
            statistics=layers.statistics | frame_input.counts,
        )

    def header(self, frame: int) -> dict[str, Any]:
        """Make the header of a frame's file: all that determines its pixels."""
        fps = self._preset.camera.fps
        header = frame_header(self._scene.camera(frame), fps, self.settings, frame)
        return header | picture_windows(self._preset.render.size, self._preset.render.window)
