"""What a preset says of live actors: who they are, what they do, and the script of messages."""

from typing import Annotated, Literal

from pydantic import Field

from scenes.preset.object_tables import ModelTable, StandingTable
from scenes.preset.values import Metres, Table, key

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

    count: Annotated[int, key("how many", least=1, most=100_000)]
    centre: Annotated[
        tuple[Metres, Metres], key("middle of the square: (x, y) from the plane's origin [m]")
    ] = (0.0, 0.0)
    side: Annotated[float, key("side of the square [m]", above=0, most=1e6)] = 40.0
    prototypes: Annotated[int, key("different objects of this model", least=1, most=256)] = 1
    behaviour: BehaviourName = ""
    options: Options = Field(default_factory=dict)


class ScriptLine(Table):
    """A message, sent at a time."""

    at: Annotated[float, key("when it begins, frame 1 is at 0 [s]", least=0, most=1e6)] = 0.0
    to: Annotated[str, key("who, and the route to the part, as joe right leg/lower leg/foot")]
    do: Annotated[str, key("what is asked for, as orient y 40deg")]
    over: Annotated[float, key("how long it takes [s]; 0 = at once", least=0, most=1e6)] = 0.0
    ease: Annotated[Literal["linear", "smooth"], key("how it goes on meanwhile")] = "smooth"


class ActingPreset(Table):
    """How long the actors act, and who may wait for an update."""

    frames: Annotated[int, key("frames in which they act", least=1, most=10**6)] = 96
    threshold: Annotated[
        float,
        key("an actor that is off by less may coast [px]; 0 = all are updated", least=0, most=64),
    ] = 0.0
    budget: Annotated[
        Annotated[int, Field(ge=1, le=10**6)] | None,
        key("updates in a frame at most, 1 to 1e6; absent = as many as are due"),
    ] = None
