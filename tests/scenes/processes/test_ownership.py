"""A folder has one owner at a time, and the dead own nothing."""

import contextlib
import multiprocessing
import os
import signal
import time

import pytest

from lod.errors import InputError
from scenes.processes import ownership as module
from scenes.processes.ownership import NAME, owned

spawning = multiprocessing.get_context("fork")


@pytest.fixture(autouse=True)
def not_for_ever():
    """End a test that waits for a folder nobody gives up."""

    def ended(*_):
        raise TimeoutError("it was waited for too long")

    before = signal.signal(signal.SIGALRM, ended)
    signal.setitimer(signal.ITIMER_REAL, 120)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)


def own(folder, group):
    return owned(folder, group, "works there")


def held(folder, group, pipe):
    with own(folder, group):
        pipe.send("ready")
        pipe.recv()


@contextlib.contextmanager
def holder(folder, group):
    """Another process that holds the folder."""
    here, there = spawning.Pipe()
    process = spawning.Process(target=held, args=(folder, group, there))
    process.start()
    assert here.poll(30) and here.recv() == "ready"
    try:
        yield process
    finally:
        here.send("end")
        process.join(30)


def test_others_are_refused_by_name_and_those_of_the_group_are_not(tmp_path):
    with holder(tmp_path, "one") as process:
        with (
            pytest.raises(InputError, match=f"process {process.pid} on .* works there"),
            own(tmp_path, "two"),
        ):
            pass
        with own(tmp_path, "one"):
            pass
        with pytest.raises(InputError), own(tmp_path, "two"):
            pass
    with own(tmp_path, "two"):
        assert os.listdir(tmp_path / NAME) == ["owner"]
    assert os.listdir(tmp_path) == []


def test_one_of_the_group_may_stay_longer_than_the_first(tmp_path):
    with contextlib.ExitStack() as first, own(tmp_path, "one"):
        first.enter_context(own(tmp_path, "one"))
        first.close()
        with pytest.raises(InputError), own(tmp_path, "two"):
            pass


def test_a_folder_of_the_dead_is_taken_over_at_once(tmp_path):
    with holder(tmp_path, "one") as process:
        os.kill(process.pid, signal.SIGKILL)
        process.join()
        assert os.listdir(tmp_path / NAME) == ["owner"]
        start = time.monotonic()
        with own(tmp_path, "two"):
            assert time.monotonic() - start < 1
    assert os.listdir(tmp_path) == []


def test_where_there_are_no_locks_it_says_so_and_goes_on(tmp_path, monkeypatch):
    def no_locks(*_):
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr(module.fcntl, "flock", no_locks)
    said = []
    with owned(tmp_path, "one", "works there", said.append), own(tmp_path, "two"):
        pass
    assert len(said) == 1 and "has no locks (Function not implemented)" in said[0]


def test_what_others_left_in_the_folder_stays(tmp_path):
    (tmp_path / NAME).mkdir()
    (tmp_path / NAME / "y.owner").mkdir()
    with own(tmp_path, "two"):
        pass
    assert os.listdir(tmp_path / NAME) == ["y.owner"]


def test_one_that_sleeps_keeps_its_lock(tmp_path):
    with holder(tmp_path, "one") as process:
        os.kill(process.pid, signal.SIGSTOP)
        with pytest.raises(InputError), own(tmp_path, "two"):
            pass
        os.kill(process.pid, signal.SIGCONT)


@pytest.mark.parametrize("text", [b"", b"{", b"[]", b"5", b"\xff" * 700])
def test_what_names_no_owner_is_written_anew(tmp_path, text):
    (tmp_path / NAME).mkdir()
    (tmp_path / NAME / "owner").write_bytes(text)
    with own(tmp_path, "two"):
        assert b'"two"' in (tmp_path / NAME / "owner").read_bytes()
    assert os.listdir(tmp_path) == []


def entering(folder, group, inside, seen, turns):
    for _ in range(turns):
        with contextlib.suppress(InputError), own(folder, group):
            with inside[group].get_lock():
                inside[group].value += 1
            seen[group].value += 1
            others = [each.value for name, each in inside.items() if name != group]
            seen["both"].value += any(others)
            time.sleep(0.002)
            with inside[group].get_lock():
                inside[group].value -= 1


def test_two_groups_are_never_inside_at_once(tmp_path):
    names = ("one", "two", "three")
    inside = {name: spawning.Value("i", 0) for name in names}
    seen = {name: spawning.Value("i", 0) for name in (*names, "both")}
    every = [
        spawning.Process(target=entering, args=(tmp_path, name, inside, seen, 40)) for name in names
    ]
    for process in every:
        process.start()
    for process in every:
        process.join(120)
    assert [process.exitcode for process in every] == [0, 0, 0]
    assert seen["both"].value == 0
    assert sum(seen[name].value for name in names) > 10
    assert os.listdir(tmp_path) == []
