"""The pose track of a sequence: a file beside its frames, made once, from which frames replay."""

from collections.abc import Sequence
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
from scenes.presets.load import has_acting
from scenes.presets.schema import Preset
from scenes.render.exr.header import software
from scenes.render.exr.sequence import settings_hash
from scenes.render.memory import preflight
from scenes.scene import Scene
from scenes.world.cast import make_cast
from scenes.world.world import make_terrain

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
