"""The rules of §3.2 over generated hierarchies and routes."""

import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lod.actors.actor import CompoundActor, RevoluteJoint, SimpleActor
from lod.actors.object_with_parts import Action, Answer, Message, Refusal, ask, change, mutator
from lod.errors import InputError

# Unlike one another, so that a name with one letter wrong is still nearest to itself.
NAMES = "torso chest hand forearm big-toe skull knee liver whisker tail fin eyelid".split()

numbers = st.floats(-9, 9, allow_subnormal=False)
places = st.tuples(numbers, numbers, numbers)


@st.composite
def families(draw):
    """Which name belongs to which: {name: name of its whole}, "" for the root."""
    names = draw(st.permutations(NAMES))[: draw(st.integers(1, len(NAMES)))]
    return {name: draw(st.sampled_from(["", *names[:i]])) for i, name in enumerate(names)}


@st.composite
def addressed(draw):
    """A family, and the route to one of its parts."""
    family = draw(families())
    return family, route_to(draw(st.sampled_from(sorted(family))), family)


def route_to(name, family):
    return (*route_to(family[name], family), name) if name else ()


def assembled(family, special=None, name=""):
    """An actor for a family; ``special`` gives some wholes a class of their own."""
    parts = {part: assembled(family, special, part) for part in family if family[part] == name}
    joint = RevoluteJoint((len(name), 0.5, -len(parts)), (0.1, len(name), 0.2, 1.0))
    called = name or "root"
    if special and name in special:
        return special[name](parts, joint, name=called)
    return CompoundActor(parts, joint, name=called) if parts else SimpleActor(joint, name=called)


def state(actor):
    """Every bit of place and orientation of every part."""
    joints = {r: actor.receive(ask(r, "joint")).value for r in [(), *actor.routes()]}
    return {r: struct.pack("7d", *joint.position, *joint.turn) for r, joint in joints.items()}


class Watcher(CompoundActor):
    """Notes what it sees and lets it pass."""

    def intercept(self, message):
        self.__dict__.setdefault("seen", []).append(message)
        return message


class Mover(CompoundActor):
    """Whatever is to be placed in it is placed a metre higher."""

    def intercept(self, message):
        if message.action.name != "place":
            return message
        x, y, z = message.action.arguments[0]
        return Message(message.route, Action("place", ((x, y, z + 1),), changes=True))


class Meddler(CompoundActor):
    """Moves itself and all that it owns, and then will not have it."""

    def intercept(self, message):
        if not message.action.changes:
            return message
        self._joint = self._joint.with_position((7, 7, 7))
        self.fresh = True
        for name in self.part_names():
            self._ask_part(change((name,), "turn", (1, 1, 1), 33))
        return self.refuse("no")


class Thrower(CompoundActor):
    """Changes, and then breaks."""

    @mutator
    def trip(self):
        self.place((8, 8, 8))
        for name in self.part_names():
            self._ask_part(change((name,), "place", (8, 8, 8)))
        raise ZeroDivisionError


@settings(max_examples=60)
@given(addressed(), places)
def test_a_message_reaches_the_part_it_names_and_no_other(case, place):
    family, route = case
    actor = assembled(family)
    before = state(actor)
    assert isinstance(actor.receive(change(route, "place", place)), Answer)
    after = state(actor)
    assert {r for r in before if after[r] != before[r]} <= {route}
    assert actor.receive(ask(route, "position")).value == place


@settings(max_examples=60)
@given(addressed(), places)
def test_every_whole_on_the_way_sees_the_message_unchanged_and_nobody_else(case, place):
    family, route = case
    wholes = {"", *family.values()}
    actor = assembled(family, dict.fromkeys(wholes, Watcher))
    message = change(route, "place", place)
    assert isinstance(actor.receive(message), Answer)
    for whole in wholes:
        way = route_to(whole, family)
        seen = vars(inside(actor, way)).get("seen", [])
        if way == route[: len(way)] and way != route:
            assert [m.route for m in seen] == [route[len(way) :]]
            assert seen[0].action is message.action
        else:
            assert seen == []


def inside(actor, way):
    """The part itself: the test looks where no public name leads."""
    for name in way:
        actor = actor._ObjectWithParts__parts[name]
    return actor


@settings(max_examples=60)
@given(addressed(), places, st.data())
def test_a_modifying_whole_modifies(case, place, data):
    family, route = case
    mover = data.draw(st.sampled_from(("", *route[:-1])))
    actor = assembled(family, {mover: Mover})
    before = state(actor)
    assert isinstance(actor.receive(change(route, "place", place)), Answer)
    x, y, z = place
    assert actor.receive(ask(route, "position")).value == (x, y, z + 1)
    after = state(actor)
    assert {r for r in before if after[r] != before[r]} <= {route}


@settings(max_examples=60)
@given(addressed(), places, st.data())
def test_a_rejected_change_leaves_every_bit_and_says_who_and_why(case, place, data):
    family, route = case
    meddler = data.draw(st.sampled_from(("", *route[:-1])))
    actor = assembled(family, {meddler: Meddler})
    before = state(actor)
    reply = actor.receive(change(route, "place", place))
    who = "/".join(("root", *route_to(meddler, family)))
    assert reply == Refusal(who, "no")
    assert state(actor) == before
    assert not hasattr(inside(actor, route_to(meddler, family)), "fresh")


@given(families(), st.data())
def test_a_change_broken_off_by_an_error_leaves_every_bit(family, data):
    thrower = data.draw(st.sampled_from(["", *sorted(family)]))
    actor = assembled(family, {thrower: Thrower})
    before = state(actor)
    with pytest.raises(ZeroDivisionError):
        actor.receive(change(route_to(thrower, family), "trip"))
    assert state(actor) == before
    # Nor is it left as if it were still at work: it can be sent messages as before.
    assert isinstance(actor.receive(change("", "place", (1, 2, 3))), Answer)


@settings(max_examples=60)
@given(addressed(), st.data())
def test_an_unknown_route_names_the_nearest_known_one(case, data):
    family, route = case
    at = data.draw(st.integers(0, len(route) - 1))
    letter = data.draw(st.integers(0, len(route[at]) - 1))
    wrong = route[at][:letter] + "#" + route[at][letter + 1 :]
    actor = assembled(family)
    before = state(actor)
    reply = actor.receive(change((*route[:at], wrong, *route[at + 1 :]), "place", (1, 2, 3)))
    assert isinstance(reply, Refusal)
    assert reply.who == "/".join(("root", *route[:at]))
    assert f"no part {wrong!r}" in reply.why
    assert repr("/".join(route)) in reply.why
    assert state(actor) == before


@settings(max_examples=60)
@given(addressed(), st.data())
def test_an_owned_part_cannot_be_owned_again(case, data):
    family, route = case
    actor = assembled(family)
    part = inside(actor, route)  # as if the caller had kept it when the whole was assembled
    before, spare = state(actor), SimpleActor()
    with pytest.raises(InputError) as error:
        CompoundActor({"spare": spare, "stolen": part}, name="thief")
    owner = "/".join(("root", *route[:-1]))
    assert "thief.parts['stolen']" in str(error.value)
    assert f"belongs to {owner}" in str(error.value)
    assert state(actor) == before
    # The failed assembly has taken nothing.
    assert isinstance(CompoundActor({"spare": spare}), CompoundActor)


@given(addressed())
def test_a_kept_part_answers_to_its_whole_only(case):
    family, route = case
    actor = assembled(family)
    part, before = inside(actor, route), state(actor)
    reply = part.receive(change("", "place", (1, 2, 3)))
    assert isinstance(reply, Refusal)
    assert reply.who == "/".join(("root", *route))
    for call in (part.position, part.orientation, part.frames, part.routes):
        with pytest.raises(ValueError, match="is part of root"):
            call()
    with pytest.raises(ValueError, match="is part of root"):
        part.turn((0, 0, 1), 40)
    assert state(actor) == before
