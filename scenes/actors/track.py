"""A pose track: all that actors do in all frames, as arrays, with a hash of them.

Frames are replayed from it in any order. The numbers that act may differ in their last bits between
processors; those of one track do not.
"""

import hashlib
import io
import json
import zipfile
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from scenes.actors.performance import ActedFrame, Eye, Held, Performance

_NAMES = ("places", "updated", "bound_px", "eye", "held_at", "held_turn")


class Track(NamedTuple):
    """The frames 1 to F + 1 of n actors; rows of ``held`` are limbs that messages hold.

    places (F + 1, n, 6), updated and bound_px (F + 1, n): as in ActedFrame
    eye (F + 1, 5): NaN where the camera is as the preset has it
    held_at (h, 3): frame − 1, actor and joint; held_turn (h, 4)
    """

    names: tuple[str, ...]
    places: np.ndarray
    updated: np.ndarray
    bound_px: np.ndarray
    eye: np.ndarray
    held_at: np.ndarray
    held_turn: np.ndarray

    @property
    def digest(self) -> str:
        """Compute the SHA-256 of names, shapes and numbers, in little-endian order."""
        found = hashlib.sha256(json.dumps(self.names).encode())
        for array in self[1:]:
            found.update(f"\n{array.dtype.name} {array.shape}\n".encode())
            found.update(array.astype(array.dtype.newbyteorder("<"), copy=False).tobytes())
        return found.hexdigest()


def track_of(performance: Performance) -> Track:
    """Act all frames, and lay them out as arrays."""
    return _laid_out(performance.names, performance.all_frames())


def performance_of(track: Track) -> Performance:
    """Return the frames of a track."""
    held: list[Held] = [{} for _ in track.places]
    for (frame, actor, joint), turn in zip(
        track.held_at.tolist(), track.held_turn.tolist(), strict=True
    ):
        x, y, z, w = turn
        held[frame][actor] = (*held[frame].get(actor, ()), (joint, (x, y, z, w)))
    frames = [
        ActedFrame(places, updated, bound, limbs, None if np.isnan(eye[0]) else Eye(*eye.tolist()))
        for places, updated, bound, eye, limbs in zip(*track[1:5], held, strict=True)
    ]
    return Performance(track.names, frames, None, len(frames) - 1)


def to_bytes(track: Track) -> bytes:
    """Pack a track, with its hash."""
    target = io.BytesIO()
    found: dict[str, Any] = dict(zip(_NAMES, track[1:], strict=True))
    found |= {"names": json.dumps(track.names), "sha256": track.digest, "by": "lodbench"}
    np.savez_compressed(target, **found)
    return target.getvalue()


def from_bytes(data: bytes) -> Track:
    """Unpack a track. Raises ValueError for what is none, or is not as it was written."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            names = tuple(json.loads(str(file["names"])))
            track = Track(names, *(file[name] for name in _NAMES))
            digest = str(file["sha256"])
    except (OSError, EOFError, KeyError, zipfile.BadZipFile) as error:
        raise ValueError(str(error)) from error
    if track.digest != digest:
        raise ValueError("its numbers do not have the hash that it says")
    return track


def _laid_out(names: Sequence[str], frames: Sequence[ActedFrame]) -> Track:
    at = [
        (frame, actor, joint)
        for frame, each in enumerate(frames)
        for actor in sorted(each.held)
        for joint, _ in each.held[actor]
    ]
    turns = [turn for each in frames for actor in sorted(each.held) for _, turn in each.held[actor]]
    return Track(
        tuple(names),
        np.array([each.places for each in frames]).reshape(len(frames), len(names), 6),
        np.array([each.updated for each in frames]).reshape(len(frames), len(names)),
        np.array([each.bound_px for each in frames]).reshape(len(frames), len(names)),
        np.array([each.eye or (np.nan,) * 5 for each in frames], np.float64),
        np.array(at, np.int64).reshape(-1, 3),
        np.array(turns, np.float64).reshape(-1, 4),
    )
