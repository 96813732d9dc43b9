"""The window of a picture that is rendered: a crop, or the whole."""

from dataclasses import dataclass

import numpy as np

from lod.errors import InputError


@dataclass(frozen=True)
class Window:
    """A rectangle of pixels: from (left, top) to before (right, bottom), rows from the top."""

    left: int
    top: int
    right: int
    bottom: int

    def __post_init__(self) -> None:
        if not (0 <= self.left < self.right and 0 <= self.top < self.bottom):
            raise InputError("render.crop", self, "a window with pixels in it, inside the picture")

    @property
    def size(self) -> tuple[int, int]:
        """Return its width and height [px]."""
        return self.right - self.left, self.bottom - self.top

    def is_all_of(self, size: tuple[int, int]) -> bool:
        """Tell whether it is a whole picture of that size."""
        return (self.left, self.top) == (0, 0) and self.size == size

    def share(self, pixels: slice, width: int) -> tuple[np.ndarray, slice]:
        """Find what of a run of a picture's pixels lies in the window, row by row.

        ``width`` is the picture's. Gives whether each pixel of the run does, (n,), and which run of
        the window's own pixels those are.
        """
        number = np.arange(pixels.start, pixels.stop)
        row, column = number // width, number % width
        inside = (self.left <= column) & (column < self.right)
        inside &= (self.top <= row) & (row < self.bottom)
        if not inside.any():
            return inside, slice(0, 0)
        at = int(np.argmax(inside))
        own = (row[at] - self.top) * self.size[0] + column[at] - self.left
        return inside, slice(int(own), int(own) + int(np.count_nonzero(inside)))


def whole_window(size: tuple[int, int]) -> Window:
    """Return the window of a whole picture of that size [px]."""
    return Window(0, 0, *size)
