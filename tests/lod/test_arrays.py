"""An error says what arrived; of something long, both ends."""

from hypothesis import given
from hypothesis import strategies as st

from lod.errors import InputError


@given(st.text(st.characters(codec="ascii", exclude_characters="\\\n'"), max_size=300))
def test_what_arrived_is_told_in_at_most_eighty_characters(text: str) -> None:
    message = str(InputError("KEY", text, "a rule", "a cure"))
    assert message.startswith("KEY: ") and message.endswith(": a rule; a cure")
    told = message.removeprefix("KEY: ").removesuffix(": a rule; a cure")
    assert len(told) <= 80
    assert told == repr(text) or (told[:39], told[-40:]) == (repr(text)[:39], repr(text)[-40:])


def test_a_long_path_keeps_the_name_of_its_file() -> None:
    path = f"/{'a' * 200}/claims.csv"
    assert "/claims.csv'" in str(InputError("DIR", path, "a rule"))
