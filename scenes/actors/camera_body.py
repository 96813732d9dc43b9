"""The camera of a scene among its actors: it goes where the preset says until messages move it."""

from lod.actors.actor import PositionableObject
from lod.actors.dispatch import mutator, query
from lod.actors.joint import RevoluteJoint
from lod.actors.quaternion import EAST, UP, rotation
from lod.errors import InputError
from scenes.actors.performance import Eye


class CameraBody(PositionableObject):
    """A camera on the preset's path; a message may put it elsewhere, turn it, or release it.

    Its eye is its origin; it looks along its own y, its own z upwards.
    """

    def __init__(self, on_path: Eye) -> None:
        super().__init__(name="camera")
        self._placed = self._faced = False
        self._stand(on_path)

    @query
    def eye(self) -> Eye:
        """Return where it is and where it looks."""
        return self._eye

    @query
    def moved(self) -> bool:
        """Tell whether messages have put it elsewhere than the preset has it."""
        return self._placed or self._faced

    @mutator
    def follow_path(self, on_path: Eye) -> None:
        """Go on along the preset's path, as far as no message has moved it."""
        now = self._eye
        place = (now if self._placed else on_path)[:3]
        self._stand(Eye(*place, *(now if self._faced else on_path)[3:]))

    @mutator
    def stand(self, x: float, y: float, height: float) -> None:
        """Stand at a place [m], so high above the ground [m]."""
        if height <= 0:
            raise InputError("camera.stand", height, "a height above 0 m")
        self._placed = True
        self._stand(Eye(float(x), float(y), float(height), *self._eye[3:]))

    @mutator
    def face(self, heading: float, pitch: float) -> None:
        """Look along a heading, clockwise from north, and a pitch above the horizon [degrees]."""
        if abs(pitch) > 90:
            raise InputError("camera.face", pitch, "a pitch within ±90 degrees")
        self._faced = True
        self._stand(Eye(*self._eye[:3], float(heading), float(pitch)))

    @mutator
    def release(self) -> None:
        """Go back to the preset's path, from the next frame on."""
        self._placed = self._faced = False

    def _stand(self, eye: Eye) -> None:
        turn = rotation(UP, -eye.heading) * rotation(EAST, eye.pitch)
        self._set_joint(RevoluteJoint(eye[:3], turn))
        self._eye = eye
