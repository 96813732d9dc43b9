import pickle
from types import FunctionType, MethodType
from typing import ClassVar

import pytest

from lod.actors.actor import (
    IDENTITY_JOINT,
    UP,
    Actor,
    CompoundActor,
    JointLimits,
    PositionableObject,
    RevoluteJoint,
    SimpleActor,
)
from lod.actors.object_with_parts import (
    Answer,
    Message,
    ObjectWithParts,
    Refusal,
    Refused,
    ask,
    change,
    mutator,
    query,
)
from lod.errors import InputError

SHIN, FOOT = "shin", "foot"
KNEE = JointLimits((0, -5, 0), (0, 130, 0))


class Foot(SimpleActor):
    def __init__(self, name=None):
        super().__init__(RevoluteJoint((0, 0, -0.4)), FOOT, name)


class Leg(Actor):
    part_types: ClassVar = {"foot": Foot}

    def __init__(self, joint=IDENTITY_JOINT):
        super().__init__(joint=joint, appearance=SHIN)


class Person(Actor):
    part_types: ClassVar = {"left leg": Leg, "right leg": Leg}

    def __init__(self, name="joe", joint=IDENTITY_JOINT):
        hips = {"left leg": (0, 0.1, 0.5), "right leg": (0, -0.1, 0.5)}
        legs = {leg: Leg(RevoluteJoint(hip, limits=KNEE)) for leg, hip in hips.items()}
        super().__init__(legs, joint, name=name)


# Figure 3


@pytest.mark.parametrize("abstract", [ObjectWithParts, PositionableObject, Actor])
def test_abstract_classes_have_no_instances(abstract):
    with pytest.raises(TypeError, match="abstract"):
        abstract()


def test_the_types_of_the_parts_are_kept_to():
    class Table(Actor):
        part_types: ClassVar = {"leg": Leg}

    with pytest.raises(InputError, match=r"Table.parts\['leg'\].*of class Leg"):
        Table({"leg": Foot()})
    with pytest.raises(InputError, match="did you mean 'leg'"):
        Table({"leeg": Leg()})
    assert Table({"leg": Foot()}, part_types={"leg": Foot}).part_names() == ("leg",)


def test_a_whole_is_assembled_once():
    joe = Person()
    with pytest.raises(InputError, match="assembled once"):
        joe.__init__()


def test_a_simple_actor_can_have_no_parts():
    with pytest.raises(InputError, match="has no parts"):
        type("Centaur", (SimpleActor,), {"part_types": {"horse": Leg}})
    with pytest.raises(TypeError):
        SimpleActor(parts={"foot": Foot()})
    reply = Foot("paw").receive(ask("claw", "position"))
    assert reply == Refusal("paw", "has no part 'claw'; it has no parts at all")


def test_state_that_could_not_be_put_back_is_refused():
    with pytest.raises(TypeError, match="__slots__"):
        type("Sly", (SimpleActor,), {"__slots__": ("hidden",)})


# Hidden state


def holds_a_part(value, depth=0):
    """Whether a value is a part of something, or leads to one by plain names."""
    if isinstance(value, ObjectWithParts):
        return bool(value._owned_by)
    if isinstance(value, (str, bytes, int, float, type, FunctionType)) or depth > 4:
        return False
    if isinstance(value, MethodType):
        return holds_a_part(value.__self__, depth + 1)
    if isinstance(value, dict):
        return any(holds_a_part(item, depth + 1) for pair in value.items() for item in pair)
    if isinstance(value, (tuple, list, set, frozenset)):
        return any(holds_a_part(item, depth + 1) for item in value)
    return holds_a_part(getattr(value, "__dict__", {}), depth + 1)


def found_by_public_names(joe):
    """Everything that attributes and calls without arguments give, dunders too."""
    skipped = {"__getstate__", "__reduce__", "__reduce_ex__", "__init__"}
    for name in dir(joe):
        if name in skipped or (name.startswith("_") and not name.startswith("__")):
            continue
        value = getattr(joe, name)
        yield name, value
        if callable(value) and name != "__class__":
            try:
                yield name, value()
            except TypeError:
                continue


def test_no_public_name_leads_to_a_part():
    joe = Person()
    found = dict(found_by_public_names(joe))
    assert len(found) > 20
    assert [name for name, value in found.items() if holds_a_part(value)] == []


def test_no_question_leads_to_a_part():
    joe = Person()
    asked = 0
    for route in [(), *joe.routes()]:
        for name in dir(Person):
            reply = joe.receive(ask(route, name))
            asked += isinstance(reply, Answer)
            assert isinstance(reply, Refusal) or not holds_a_part(reply.value)
    assert asked > 30


def test_a_whole_cannot_be_searched_or_sent_away():
    joe = Person()
    for search in (iter, len, list, lambda whole: whole["left leg"], lambda whole: whole.left_leg):
        with pytest.raises((TypeError, AttributeError)):
            search(joe)
    assert not holds_a_part(vars(joe))
    assert repr(joe) == "<Person joe>"
    for send in (
        pickle.dumps,
        lambda whole: whole.__reduce__(),
        lambda whole: whole.__getstate__(),
    ):
        with pytest.raises(TypeError, match="stays in its process"):
            send(joe)


@pytest.mark.parametrize(
    "wrap", [lambda p: p, lambda p: [p], lambda p: {"it": (p,)}, lambda p: p.turn]
)
def test_a_question_that_would_hand_out_a_part_is_refused(wrap):
    class Careless(SimpleActor):
        @query
        def me(self):
            return wrap(self)

    reply = CompoundActor({"it": Careless()}, name="whole").receive(ask("it", "me"))
    assert reply.who == "whole/it"
    assert "hidden state" in reply.why


# What parts understand


def test_a_message_names_a_question_or_a_change_and_not_the_other():
    joe = Person()
    assert joe.receive(ask("left leg", "place", (0, 0, 0))).why.startswith(
        "understands no question"
    )
    assert "nearest is 'orient'" in joe.receive(change("left leg", "orientt")).why
    assert "takes" in joe.receive(change("left leg", "turn", UP)).why
    for name in ("__class__", "_joint", "receive", "part_types", "_ask_part"):
        assert isinstance(joe.receive(ask("", name)), Refusal)


def test_a_whole_may_answer_in_the_place_of_its_part():
    class Shy(Person):
        def intercept(self, message):
            return Message((), message.action)

    joe = Shy(joint=RevoluteJoint((9, 9, 9)))
    assert joe.receive(ask("left leg", "position")).value == (9, 9, 9)


def test_a_whole_may_not_make_a_change_of_a_question():
    class Sly(Person):
        def intercept(self, message):
            return change(message.route, "place", (0, 0, 0))

    with pytest.raises(TypeError, match="turned a question"):
        Sly().receive(ask("left leg", "position"))


def test_a_whole_changes_its_parts_all_or_none():
    class Walker(Person):
        @mutator
        def step(self, angle):
            self._ask_part(change("left leg", "bend", (0, angle, 0)))
            self._ask_part(change("right leg", "bend", (0, 10 * angle, 0)))

    joe = Walker()
    joe.step(5)
    before = joe.frames()
    with pytest.raises(Refused, match="joe/right leg refuses"):
        joe.step(20)
    assert joe.frames() == before


# Frames, looks, cameras
