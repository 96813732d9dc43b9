"""What does the camera do in the experiment ``motion``?"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Move:
    """A move of the camera: turn [degrees/s], speed [m/s], and shutter [degrees of 360 a frame]."""

    turn: float
    speed: float
    shutter: float

    @property
    def settings(self) -> tuple[str, ...]:
        """The move as settings of a preset."""
        keys = {"camera.turn": self.turn, "camera.speed": self.speed, "view.shutter": self.shutter}
        return tuple(f"{key}={value}" for key, value in keys.items())


MOVES = (
    *(Move(turn, 0.0, 180.0) for turn in (0.0, 5.0, 15.0, 45.0, 90.0, 180.0)),
    *(Move(90.0, 0.0, shutter) for shutter in (45.0, 90.0, 360.0)),
    *(Move(0.0, speed, 180.0) for speed in (1.4, 14.0, 100.0)),
)
"""Pans at one shutter, one pan at other shutters, and walks, drives and flights ahead."""

FAST = Move(90.0, 0.0, 180.0)

PICTURED = (
    (FAST, ("motion", "planted")),
    (Move(15.0, 0.0, 180.0), ("motion",)),
    (Move(180.0, 0.0, 180.0), ("motion",)),
    (Move(90.0, 0.0, 360.0), ("motion",)),
    (Move(0.0, 14.0, 180.0), ("motion",)),
)
"""The moves that are rendered, too, and the cuts of each."""
