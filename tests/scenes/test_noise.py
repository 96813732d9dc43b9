"""."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.random import Philox

from scenes.noise import hash_name, philox4x64, unit_float

WORDS = st.integers(0, 2**64 - 1)


@given(counter=st.tuples(WORDS, WORDS, WORDS, WORDS), key=st.tuples(WORDS, WORDS))
def test_blocks_are_those_of_numpys_philox(counter, key):
    """NumPy steps the 256-bit counter once before its first block."""
    number = (sum(word << (64 * k) for k, word in enumerate(counter)) - 1) % 2**256
    before = [(number >> (64 * k)) & (2**64 - 1) for k in range(4)]
    theirs = Philox(counter=np.array(before, np.uint64), key=np.array(key, np.uint64)).random_raw(4)
    ours = philox4x64(*(np.uint64(word) for word in (*counter, *key)))
    assert [int(word) for word in ours] == [int(word) for word in theirs]


def test_unit_covers_the_half_open_interval():
    assert unit_float(np.uint64(0)) == 0.0
    assert unit_float(np.uint64(2**64 - 1)) == 1 - 2.0**-53


def test_names_have_words_of_their_own():
    assert hash_name("figure") == hash_name("figure") != hash_name("tree")
