"""What a preset says of the things in its scene: species, single objects, plumes, live actors."""

import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from scenes.model_files.names import is_model_file, model_names
from scenes.presets.values import Metres, SizeFactor, Table, key, refuse

SpeciesName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]*$", max_length=64)]


def _known_model(name: str, info: Any) -> str:
    known = model_names()
    if name not in known and not is_model_file(name) and not info.data.get("model_sha256"):
        expected = f"{', '.join(map(repr, known[:-1]))} or {known[-1]!r}"
        raise PydanticCustomError("literal_error", "one of {expected}", {"expected": expected})
    return name


def _sha256(text: str | None) -> str | None:
    if text is not None and not re.fullmatch(r"[0-9a-f]{64}", text):
        raise refuse("64 hexadecimal digits", "`lodbench model show` tells them")
    return text


Model = Annotated[
    str, AfterValidator(_known_model), key("what each object is: a model, or a file beside this")
]
"""The name of a model (``scenes.model_files.names``), or of a scene file."""


class ModelTable(Table):
    """What a table says that places objects: what they are."""

    model_sha256: Annotated[str | None, AfterValidator(_sha256)] = key(
        "hash that an imported model must have, as `model show` tells it", None
    )
    model: Model


class SpeciesPreset(ModelTable):
    """One Poisson field of objects."""

    density: float = key("objects per unit ground area [1/m²]", least=0, most=100)
    prototypes: int = key("different objects of this model", 1, least=1, most=256)
    sizes: Annotated[tuple[SizeFactor, ...], Field(min_length=1, max_length=64)] = key(
        "size factors, 1 to 64 of them, equally likely, each from 0.001 to 1000", (1.0,)
    )
    metric: Literal["blake", "bounded", "solid_angle"] | None = key(
        "metric that decides for this species; absent: view.metric, as with full and depth", None
    )
    patrol: float = key(
        "radius of the round that each one walks [m]; 0 = stays at home", 0.0, least=0, most=1000
    )
    dust: bool = key("whether feet throw up dust; only for what has a patrol", False)
    highest: float | None = key(
        "height above the datum where none grows [m]", None, least=-1e5, most=1e5
    )
    thinning: float = key(
        "how far below `highest` it begins to thin out [m]", 100.0, least=1, most=1e5
    )
    steepest: float | None = key(
        "tangent of the slope where none stands", None, least=0.01, most=100
    )


class StandingTable(ModelTable):
    """What a table says of one object: what it is, where it stands, and what it faces."""

    position: tuple[Metres, Metres] = key(
        "where it stands, or begins: (x, y) from the plane's origin [m]"
    )
    heading: float = key("what it faces, clockwise from north [degrees]", 0.0, least=-360, most=360)
    prototype: int = key("which of the model's objects, from 1", 1, least=1, most=256)
    size: SizeFactor = key("size factor", 1.0)


class PlacedPreset(StandingTable):
    """One object, put where the picture wants it."""

    walks: bool = key("whether it walks on the spot", False)


class PlumePreset(Table):
    """Smoke or flames rising from the ground."""

    kind: Literal["smoke", "flames"] = key("what rises")
    position: tuple[Metres, Metres] = key("where it stands: (x, y) from the plane's origin [m]")
    size: SizeFactor = key("size factor", 1.0)
    wind: float | None = key(
        "where it is blown to, clockwise from north [degrees]; absent: wind.direction",
        None,
        least=-360,
        most=360,
    )


class RepresentationPreset(Table):
    """What an installed package makes (scenes.plugins)."""

    kind: str = key("which of those that are installed, see `lodbench list`")
    options: dict[str, bool | int | float | str] = key("options that its package documents", {})


Options = Annotated[
    dict[str, bool | int | float | str], key("options that the behaviour documents")
]
BehaviourName = Annotated[
    str, key("what it does by itself, see `lodbench list`; absent = only what messages say")
]


class ActorPreset(StandingTable):
    """One live actor."""

    behaviour: BehaviourName = ""
    options: Options = Field(default_factory=dict)


class TroupePreset(ModelTable):
    """Several live actors of a kind, NAME_1 to NAME_n, spread over a square without overlapping."""

    count: int = key("how many", least=1, most=100_000)
    centre: tuple[Metres, Metres] = key(
        "middle of the square: (x, y) from the plane's origin [m]", (0.0, 0.0)
    )
    side: float = key("side of the square [m]", 40.0, above=0, most=1e6)
    prototypes: int = key("different objects of this model", 1, least=1, most=256)
    behaviour: BehaviourName = ""
    options: Options = Field(default_factory=dict)


class ScriptLine(Table):
    """A message, sent at a time."""

    at: float = key("when it begins, frame 1 is at 0 [s]", 0.0, least=0, most=1e6)
    to: str = key("who, and the route to the part, as joe right leg/lower leg/foot")
    do: str = key("what is asked for, as orient y 40deg")
    over: float = key("how long it takes [s]; 0 = at once", 0.0, least=0, most=1e6)
    ease: Literal["linear", "smooth"] = key("how it goes on meanwhile", "smooth")


class ActingPreset(Table):
    """How long the actors act, and who may wait for an update."""

    frames: int = key("frames in which they act", 96, least=1, most=10**6)
    threshold: float = key(
        "an actor that is off by less may coast [px]; 0 = all are updated", 0.0, least=0, most=64
    )
    budget: Annotated[int, Field(ge=1, le=10**6)] | None = key(
        "updates in a frame at most, 1 to 1e6; absent = as many as are due", None
    )
