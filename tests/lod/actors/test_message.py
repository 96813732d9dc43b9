import doctest
import importlib

import pytest

from lod.actors.object_with_parts import Answer, Refusal, Refused, nearest_route, parse_route
from lod.errors import InputError

MODULES = ("actor", "object_with_parts")


@pytest.mark.parametrize("module", MODULES)
def test_the_examples_in_the_docstrings_run(module):
    outcome = doctest.testmod(importlib.import_module(f"lod.actors.{module}"))
    assert outcome.attempted > 0
    assert outcome.failed == 0


def test_a_route_is_read_with_slashes_dots_or_as_names():
    names = ("right leg", "lower leg", "foot")
    assert parse_route("right leg/lower leg/foot") == names
    assert parse_route("right leg.lower leg.foot") == names
    assert parse_route(names) == names
    assert parse_route("") == ()


@pytest.mark.parametrize("route", ["leg//foot", "/leg", "leg/", " ", ("leg", "")])
def test_a_route_without_a_name_is_refused(route):
    with pytest.raises(InputError, match="names with one / between"):
        parse_route(route)


def test_an_answer_has_a_value_and_a_refusal_none():
    assert Answer(3).value == 3
    with pytest.raises(Refused, match="joe/leg refuses: it hurts") as refused:
        _ = Refusal("joe/leg", "it hurts").value
    assert (refused.value.who, refused.value.why) == ("joe/leg", "it hurts")


@pytest.mark.parametrize(
    ("asked", "meant"),
    [
        ("right leg/lower leg/fot", "right leg/lower leg/foot"),
        ("foot", "left leg/lower leg/foot"),
        ("rigth leg", "right leg"),
        ("right leg/foot", "right leg/lower leg/foot"),
        ("hed", "head"),
    ],
)
def test_the_nearest_route_is_what_was_meant(asked, meant):
    known = [parse_route(side + way) for side in ("left leg", "right leg") for way in WAYS]
    assert nearest_route(parse_route(asked), [parse_route("head"), *known]) == parse_route(meant)


WAYS = ("", "/lower leg", "/lower leg/foot")
