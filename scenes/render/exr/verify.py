"""Every frame of a folder against what it says of itself, and what is wrong rendered again."""

import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from lod.errors import InputError
from scenes.files import stray_partials
from scenes.presets.schema import Preset
from scenes.render.exr.frames_on_disk import (
    Job,
    Kinds,
    WholeFrame,
    is_remains,
    owned_folder,
    read_whole,
    sequences_in,
    settings_hash,
)
from scenes.render.exr.header import Record, Settings, preset_from_settings, software
from scenes.render.exr.layer_file import channel_types, read_pixels

_SIGNED = ("N.", "motion.", "Crypto")  # layers whose numbers may be below 0

_NUMBER = re.compile(r"\d{4,}")


@dataclass(frozen=True)
class Checked:
    """One checked file: its frame (None for what is none), and everything that is wrong with it.

    settings  to render it with again; None where nothing says which
    """

    path: Path
    frame: int | None
    wrong: tuple[str, ...] = ()
    settings: Settings | None = None


def check_folder(folder: Path, frames: Sequence[int] | None = None) -> Iterator[Checked]:
    """Check every frame of a folder, right or wrong, and what lies beside them.

    frames  those that every sequence there should have; by default those of which an evenly spaced
        sequence has the one before and one after
    Raises InputError for a folder without frames.
    """
    names = sorted(os.listdir(folder)) if folder.is_dir() else []
    whole, kinds = sequences_in(folder) if names else ({}, {})
    damaged = [name for name in names if name.endswith(".exr") and name not in whole]
    damaged = [each for each in damaged if expected(each, kinds) or is_remains(folder / each)]
    if not whole and not damaged:
        cure = "give the folder of `lodbench render`"
        raise InputError("DIR", str(folder), "a folder with frames of lodbench", cure)
    there, others = [], {}
    for name in sorted([*whole, *damaged]):
        if name in whole:
            checked = _check_whole(folder / name, whole[name])
        else:
            checked = _check_damaged(folder / name, expected(name, kinds))
        if checked.frame is None:
            others[checked.path] = checked
        else:
            there.append(name)
            yield checked
    for missing in _missing(folder, there, kinds, frames):
        other = others.pop(missing.path, missing)  # what stands in its place, if anything does
        yield replace(missing, wrong=other.wrong)
    yield from others.values()
    for _, path in stray_partials(folder):
        yield Checked(path, None, ("a partial file, whose writer is no more",))


def expected(name: str, kinds: Kinds) -> list[tuple[int, Settings]]:
    """Find what a file of that name may be: frame and settings in each sequence of the folder."""
    found = []
    for (before, after), several in kinds.items():
        number = name[len(before) : len(name) - len(after)]
        if name == f"{before}{number}{after}" and _NUMBER.fullmatch(number):
            found += [(int(number), settings) for settings in several.values()]
    return found


def _check_whole(path: Path, whole: WholeFrame) -> Checked:
    """Check what a hash cannot: the frame's name, and its channels and pixels."""
    numbers = [int(number) for number in _NUMBER.findall(path.name)]
    if len(numbers) == 1 and f"{whole.frame:04d}" not in path.name:
        wrong = f"its header says that it is frame {whole.frame}"
        return Checked(path, numbers[0], (wrong,), whole.settings)
    try:
        pixels, _ = read_pixels(path)
        faults = _layers(pixels, preset_from_settings(whole.settings))
    except InputError as error:
        faults = [str(error)]
    return Checked(path, whole.frame, tuple(faults), whole.settings)


def _check_damaged(path: Path, candidates: list[tuple[int, Settings]]) -> Checked:
    frames = {frame for frame, _ in candidates} or set(map(int, _NUMBER.findall(path.name)))
    frame = frames.pop() if len(frames) == 1 else None
    if not path.is_file():
        return Checked(path, frame, ("it is no plain file",))
    if not is_remains(path):
        return Checked(path, None, ("it looks like a frame, and is none",))
    wrong = "its bytes are not those that were written (SHA-256)"
    return Checked(path, frame, (wrong,), _only([settings for _, settings in candidates]))


def _missing(
    folder: Path, names: Sequence[str], kinds: Kinds, frames: Sequence[int] | None
) -> Iterator[Checked]:
    for (before, after), several in kinds.items():
        own = {(before, after): several}
        there = sorted({frame for name in names for frame, _ in expected(name, own)})
        step = math.gcd(*(later - one for one, later in pairwise(there))) or 1
        wanted = frames or range(there[0], there[-1], step)
        for frame in sorted(set(wanted) - set(there)):
            path = folder / f"{before}{frame:04d}{after}"
            yield Checked(path, frame, ("there is no such file",), _only(list(several.values())))


def _only(several: list[Settings]) -> Settings | None:
    return several[0] if len(several) == 1 else None


def _layers(pixels: Mapping[str, np.ndarray], preset: Preset) -> list[str]:
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


def repairs(
    folder: Path, wrong: Iterable[Checked], render: Callable[[Job], Iterator[Record]]
) -> Iterator[Checked]:
    """Put right what is wrong, and look again: frames rendered with the settings of their like.

    ``render`` is given a job for each kind of settings, and gives a record for each of its frames,
    in any order. Gives every file once, as it is then.
    """
    jobs: dict[tuple[str, str], list[Checked]] = {}
    for found in wrong:
        if found.frame is None:  # of what is no frame, only partial files are ours to remove
            if found.path.suffix == ".part":
                found.path.unlink(missing_ok=True)
                found = Checked(found.path, None)
            yield found
        elif found.settings is None:
            why = "no whole frames of one kind say with which settings: render it again"
            yield _still(found, why)
        elif (made := found.settings.get("software")) != (here := software()):
            yield _still(found, f"it was made by {made}; {here} would make another")
        else:
            kind = _NUMBER.sub("#", found.path.name), settings_hash(found.settings)
            jobs.setdefault(kind, []).append(found)
    for several in jobs.values():
        settings = several[0].settings
        assert settings is not None
        with owned_folder(folder, settings):
            yield from _rendered(settings, several, render)


def _rendered(
    settings: Settings, several: Sequence[Checked], render: Callable[[Job], Iterator[Record]]
) -> Iterator[Checked]:
    left = {found.path.name: found for found in several}
    paths = {found.frame: found.path for found in several if found.frame is not None}
    try:
        for record in render(Job(paths, settings, {}, overwrite=True)):
            found = left.pop(Path(record["path"]).name)
            if "error" in record:
                yield _still(found, record["error"])
            else:
                yield _check_whole(found.path, read_whole(found.path))
    except InputError as error:
        for found in left.values():
            yield _still(found, str(error))


def _still(found: Checked, why: str) -> Checked:
    return replace(found, wrong=(*found.wrong, why))
