"""Work that is done once and then kept: what is told of it, and that kept work is silent."""

import numba
import pytest

from scenes.processes.progress import followed_by, kernels_told, steps, tell, work


@pytest.fixture
def told():
    """What is told inside a test."""
    found = []
    with followed_by(lambda *each: found.append(each)):
        yield found


def test_steps_are_told_and_those_that_were_kept_are_counted(told):
    with work("fits", 6):
        with steps(3):
            pass  # kept
        with steps(2):
            tell()
            tell(1.0)
            tell(1.0)
    assert told == [("fits", 3.0, 6), ("fits", 4.0, 6), ("fits", 5.0, 6), ("fits", 6, 6)]


def test_work_that_was_all_kept_is_silent(told):
    with work("fits", 2), steps(2):
        pass
    tell(1.0)  # part of no work
    assert told == []


def test_work_that_fails_is_not_told_to_be_done(told):
    with pytest.raises(ZeroDivisionError), work("fits", 2):
        tell()
        raise ZeroDivisionError
    assert told == [("fits", 0.0, 2)]


def test_kernels_are_counted_while_they_are_compiled(told):
    kernel = numba.njit(lambda x: x + 1)
    with kernels_told():
        kernel(1)
        kernel(1)  # compiled before
        kernel(1.0)
    assert [each[0].rsplit(": ")[1] for each in told] == ["1", "2"]
    kernel(1j)
    assert len(told) == 2
