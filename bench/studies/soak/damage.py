"""What do disks, people and other programs do to files? Each kind of damage, by name."""

import contextlib
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from bench.studies.soak.looks import frame_files

MANIFEST = "manifest.json"


def _truncate(path: Path, place: float) -> None:
    os.truncate(path, int(place * path.stat().st_size))


def _flip(path: Path, place: float) -> None:
    data = bytearray(path.read_bytes())
    bit = int(place * 8 * len(data))
    data[bit // 8] ^= 1 << bit % 8
    path.write_bytes(bytes(data))


def _zero(path: Path, place: float) -> None:
    path.write_bytes(bytes(path.stat().st_size))


def _append(path: Path, place: float) -> None:
    path.write_bytes(path.read_bytes() + b"\0")


def _delete(path: Path, place: float) -> None:
    path.unlink()


def _other(path: Path, place: float) -> Path:
    others = frame_files(path.parent)
    return others[int(place * len(others))]


def _swap(path: Path, place: float) -> None:
    other = _other(path, place)
    ours, theirs = path.read_bytes(), other.read_bytes()
    path.write_bytes(theirs)
    other.write_bytes(ours)


def _copy(path: Path, place: float) -> None:
    path.write_bytes(_other(path, place).read_bytes())


def _edit(change: Callable[[dict[str, Any], float], None]) -> Callable[[Path, float], None]:
    """Make a damage of the manifest that stays JSON, as an editor's hand leaves it."""

    def edit(path: Path, place: float) -> None:
        data = json.loads(path.read_text(encoding="utf-8"))
        if data["frames"]:
            change(data, place)
        path.write_text(json.dumps(data, indent=1), encoding="utf-8")

    return edit


def _entry(data: dict[str, Any], place: float) -> str:
    names = sorted(data["frames"])
    return names[int(place * len(names))]


def _forget(data: dict[str, Any], place: float) -> None:
    del data["frames"][_entry(data, place)]


def _hash(data: dict[str, Any], place: float) -> None:
    data["frames"][_entry(data, place)]["sha256"] = f"{int(place * 2**256):064x}"


def _state(data: dict[str, Any], place: float) -> None:
    data["frames"][_entry(data, place)]["state"] = "pending"


def _settings(data: dict[str, Any], place: float) -> None:
    for each in data["settings"].values():
        each["render"]["spp"] = 3


def _other_settings(data: dict[str, Any], place: float) -> None:
    data["frames"][_entry(data, place)]["settings"] = sorted(data["settings"])[-1]


def _exchange(data: dict[str, Any], place: float) -> None:
    first, last = _entry(data, 0.0), _entry(data, place)
    frames = data["frames"]
    frames[first], frames[last] = frames[last], frames[first]


def _stray(path: Path, place: float) -> None:
    gone = f".a.{int(place * 12) + 1:04d}.exr.{os.uname().nodename}-999999999.part"
    (path.parent / gone).write_bytes(b"half a frame")


def _foreign(path: Path, place: float) -> None:
    (path.parent / f"a.{int(place * 12) + 1:04d}.exr").write_bytes(b"no frame at all")


FRAME_DAMAGES: Mapping[str, Callable[[Path, float], None]] = {
    "truncate": _truncate,
    "flip": _flip,
    "zero": _zero,
    "append": _append,
    "delete": _delete,
    "swap": _swap,
    "copy": _copy,
}
MANIFEST_DAMAGES: Mapping[str, Callable[[Path, float], None]] = {
    "manifest: delete": _delete,
    "manifest: truncate": _truncate,
    "manifest: flip": _flip,
    "manifest: zero": _zero,
    "manifest: entry forgotten": _edit(_forget),
    "manifest: hash edited": _edit(_hash),
    "manifest: state edited": _edit(_state),
    "manifest: settings edited": _edit(_settings),
    "manifest: entry of other settings": _edit(_other_settings),
    "manifest: entries exchanged": _edit(_exchange),
}
PLANTS: Mapping[str, Callable[[Path, float], None]] = {
    "plant: partial file": _stray,
    "plant: foreign frame": _foreign,
}


def do_damage(folder: Path, kind: str, pick: float, place: float) -> set[str]:
    """Damage a file of a folder, chosen by two fractions; names what is not as it was."""
    if kind in FRAME_DAMAGES:
        paths = frame_files(folder)
        if not paths:
            return set()
        path, damage = paths[int(pick * len(paths))], FRAME_DAMAGES[kind]
    else:
        path, damage = folder / MANIFEST, {**MANIFEST_DAMAGES, **PLANTS}[kind]
        if not path.is_file():
            return set()
    before = _bytes(folder)
    try:
        damage(path, place)
    except (ValueError, KeyError, TypeError, OSError):
        pass  # damaged already, gone meanwhile, or no room for it
    after = _bytes(folder)
    names = {name for name, data in after.items() if before.get(name) != data}
    return names | (before.keys() - after.keys())


def _bytes(folder: Path) -> dict[str, bytes]:
    found = {}
    for name in os.listdir(folder):
        with contextlib.suppress(OSError):
            found[name] = (folder / name).read_bytes()
    return found
