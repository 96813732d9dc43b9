"""Every frame of a folder against its manifest, and what is wrong rendered again."""

import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lod.errors import InputError
from scenes.files import may_name, stray_partials
from scenes.presets.schema import Preset
from scenes.render.exr.header import (
    FRAME,
    Record,
    Settings,
    preset_from_settings,
    settings_in,
    software,
)
from scenes.render.exr.layers import channel_types, read_pixels
from scenes.render.exr.sequence import (
    DONE,
    FAILED,
    NAME,
    NOTHING_WHOLE,
    Job,
    Manifest,
    differences,
    file_hash,
    load_manifest,
    owned_folder,
    settings_hash,
)

_SIGNED = ("N.", "motion.", "Crypto")
"""Layers whose numbers may be below 0."""

_NUMBER = re.compile(r"\d{4,}")


@dataclass(frozen=True)
class Checked:
    """One checked file: its frame (None for what is none), and everything that is wrong with it."""

    path: Path
    frame: int | None
    wrong: tuple[str, ...]


def open_manifest(folder: Path, repaired: bool = False) -> Manifest:
    """Load a folder's manifest. Raises InputError where there is none, or a broken one.

    ``repaired`` says that a missing one was to be rebuilt, so that advice is not to do that.
    """
    if not (folder / NAME).is_file():
        rule, cure = f"a folder of frames with their {NAME}", "give the folder of `lodbench render`"
        if any(folder.glob("*.exr")):
            cure = "`lodbench verify --repair` rebuilds it from the frames' headers"
            if repaired:
                rule, cure = NOTHING_WHOLE
        raise InputError("DIR", str(folder), rule, cure)
    return load_manifest(folder)


def check_folder(manifest: Manifest) -> Iterator[Checked]:
    """Check every frame on record, right or wrong; then find what is wrong beside them."""
    for key, settings in manifest.settings.items():
        if settings_hash(settings) != key:
            wrong = f"settings.{key}: they are not those that were rendered (another hash)"
            yield Checked(manifest.folder / NAME, None, (wrong,))
    for name in sorted(manifest.frames):
        yield check_frame(manifest, name)
    for _, path in stray_partials(manifest.folder):
        yield Checked(path, None, ("a partial file, whose writer is no more",))
    for path in unknown_files(manifest):
        yield Checked(path, None, ("it looks like a frame, and the manifest does not know it",))


def check_frame(manifest: Manifest, name: str) -> Checked:
    """Check one frame on record: its file, its hash, its header, its channels and pixels."""
    path, entry = manifest.folder / name, manifest.frames[name]
    frame, settings = entry["frame"], manifest.settings[entry["settings"]]
    if not may_name(name, frame):
        return Checked(path, frame, (f"the manifest says that it is frame {frame}",))
    if entry["state"] != DONE:
        why = f"failed: {entry.get('error')}" if entry["state"] == FAILED else "never finished"
        return Checked(path, frame, (why,))
    if not path.is_file():
        return Checked(path, frame, ("there is no such file",))
    try:
        differs = file_hash(path) != entry["sha256"]
        wrong = ["its bytes are not those on record (SHA-256)"] if differs else []
        preset = preset_from_settings(settings)
        pixels, header = read_pixels(path)
        wrong += [*_header(header, frame, settings), *_layers(pixels, preset)]
    except InputError as error:
        wrong += [f"it is not {error.rule}" if error.where == "frame" else str(error)]
    except OSError as error:
        wrong = [f"it cannot be read ({error.strerror})"]
    return Checked(path, frame, tuple(wrong))


def _layers(pixels: Mapping[str, np.ndarray], preset: Preset) -> list[str]:
    """What is wrong with channels, size and pixels."""
    wrong = []
    left, top, right, bottom = preset.render.window
    width, height = right - left, bottom - top
    types = channel_types(preset.output, bool(preset.camera.stereo))
    for name in sorted(types.keys() - pixels.keys()):
        wrong.append(f"channel {name} is missing")
    for name, values in sorted(pixels.items()):
        expected = types.get(name)
        if expected is None:
            wrong.append(f"channel {name} is none of ours")
        elif values.dtype != expected:
            wrong.append(f"channel {name} is {values.dtype}, not {expected}")
        elif values.shape != (height, width):
            size = "×".join(str(side) for side in reversed(values.shape))
            wrong.append(f"channel {name} is {size} pixels, not {width}×{height}")
        else:
            wrong += _numbers(name, values)
    return wrong


def _header(header: Mapping[str, Any], frame: int, settings: Settings) -> Iterator[str]:
    """The frame it says it is, and the first setting that is another."""
    says = header.get(FRAME)
    if says != frame:
        yield f"its header says that it is frame {says}"
    changed = differences(settings, settings_in(header))
    if changed:
        yield f"its header has other settings ({changed[0]})"


def _numbers(name: str, values: np.ndarray) -> Iterator[str]:
    """Numbers that no frame may hold: how many, and where the first is."""
    if values.dtype.kind != "f":
        return
    kinds = {"NaN": np.isnan(values), "infinite": np.isinf(values)}
    if not name.startswith(_SIGNED):
        kinds["negative"] = values < 0
    for kind, where in kinds.items():
        if where.any():
            y, x = np.argwhere(where)[0].tolist()
            more = int(np.count_nonzero(where)) - 1
            beside = f", and {more} more" if more else ""
            yield f"{name} is {kind} at x {x}, y {y} from the upper left{beside}"


def unknown_files(manifest: Manifest) -> Iterator[Path]:
    """Find files that a reader of the sequence would take for its frames."""
    known = {_NUMBER.sub("#", name) for name in manifest.frames}
    for name in sorted(os.listdir(manifest.folder)):
        if name.endswith(".exr") and name not in manifest.frames:
            if _NUMBER.sub("#", name) in known:
                yield manifest.folder / name


def repairs(
    manifest: Manifest, wrong: Iterable[Checked], render: Callable[[Job], Iterator[Record]]
) -> Iterator[Checked]:
    """Put right what is wrong, and look again: frames rendered with the settings on record.

    ``render`` is given a job for each kind of settings, and gives a record for each of its frames,
    in any order. Gives every file once, as it is then.
    """
    jobs: dict[str, list[Checked]] = {}
    for found in wrong:
        if found.frame is None:
            yield _removed(found)
        elif why := _refusal(manifest, found):
            yield _still(found, why)
        else:
            jobs.setdefault(manifest.frames[found.path.name]["settings"], []).append(found)
    for key, several in jobs.items():
        with owned_folder(manifest.folder, manifest.settings[key]):
            yield from _rendered(manifest, manifest.settings[key], several, render)


def _refusal(manifest: Manifest, found: Checked) -> str:
    """Why a frame cannot be rendered again; nothing where it can."""
    key = manifest.frames[found.path.name]["settings"]
    settings = manifest.settings[key]
    if settings_hash(settings) != key:
        return "it cannot be rendered again: its settings were changed"
    made, here = settings.get("software"), software()
    if not may_name(found.path.name, manifest.frames[found.path.name]["frame"]):
        return "it cannot be rendered again: its number was changed"
    return "" if made == here else f"it was made by {made}; {here} would make another"


def _rendered(
    manifest: Manifest,
    settings: Settings,
    several: Sequence[Checked],
    render: Callable[[Job], Iterator[Record]],
) -> Iterator[Checked]:
    """Frames of the same settings, rendered and looked at."""
    left = {found.path.name: found for found in several}
    before = {name: manifest.frames[name]["sha256"] for name in left}
    paths = {found.frame: found.path for found in several if found.frame is not None}
    try:
        for record in render(Job(paths, settings, manifest, frozenset())):
            yield _looked_at(manifest, left.pop(Path(record["path"]).name), record, before)
    except InputError as error:
        for found in left.values():
            yield _still(found, str(error))


def _looked_at(
    manifest: Manifest, found: Checked, record: Record, before: Mapping[str, str | None]
) -> Checked:
    """A frame after it was rendered again: as it is on record, or what is wrong still."""
    if "error" in record:
        return _still(found, record["error"])
    again = check_frame(manifest, found.path.name)
    if before[found.path.name] not in (None, record["sha256"]):
        return _still(again, "rendered again, it has other bytes than before (another processor?)")
    return again


def _removed(found: Checked) -> Checked:
    """Of what is no frame, only partial files are ours to remove."""
    if found.path.suffix == ".part":
        found.path.unlink(missing_ok=True)
        return Checked(found.path, None, ())
    return found


def _still(found: Checked, why: str) -> Checked:
    return Checked(found.path, found.frame, (*found.wrong, why))
