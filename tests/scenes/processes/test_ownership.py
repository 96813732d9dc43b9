"""A folder has one owner at a time, whatever its file system can, and the dead own nothing."""

import contextlib
import fcntl
import json
import multiprocessing
import os
import signal
import time

import pytest

from scenes.processes import ownership as module
from scenes.processes.ownership import NAME, Owned, Owner, owned, ownership

spawning = multiprocessing.get_context("fork")


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(module, "BEAT_S", 0.1)
    monkeypatch.setattr(module, "SILENCE_S", 1.5)
    monkeypatch.setattr(module, "_LOOK_S", 0.05)


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


def no_locks(*_):
    raise OSError(38, "Function not implemented")


def own_locks(*_):
    """Grant every lock, as a machine does that does not tell others of them."""


@pytest.fixture(params=["locks", "no locks", "locks of another machine"])
def locks(request, monkeypatch):
    """The three kinds of file systems."""
    if request.param == "no locks":
        monkeypatch.setattr(module.fcntl, "flock", no_locks)
    if request.param == "locks of another machine":
        monkeypatch.setattr(module.fcntl, "flock", own_locks)
        monkeypatch.setattr(module, "_system", lambda: str(time.monotonic_ns()))
    return request.param


def held(folder, group, pipe):
    with ownership(folder, group):
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


@pytest.mark.usefixtures("locks")
def test_others_are_refused_by_name_and_those_of_the_group_are_not(tmp_path):
    with holder(tmp_path, "one") as process:
        with (
            pytest.raises(Owned, match=f"process {process.pid} on "),
            ownership(tmp_path, "two"),
        ):
            pass
        with ownership(tmp_path, "one"):
            pass
        with pytest.raises(Owned), ownership(tmp_path, "two"):
            pass
    with ownership(tmp_path, "two"):
        assert len(os.listdir(tmp_path / NAME)) == 1
    assert os.listdir(tmp_path) == []


def test_a_folder_of_the_dead_is_taken_over(tmp_path, locks):
    """At once where a lock died with its process, else after silence."""
    with holder(tmp_path, "one") as process:
        os.kill(process.pid, signal.SIGKILL)
        process.join()
        assert len(os.listdir(tmp_path / NAME)) == 1
        start = time.monotonic()
        with ownership(tmp_path, "two"):
            took = time.monotonic() - start
    assert (took < 1) == (locks == "locks"), took
    assert took < 10
    assert os.listdir(tmp_path) == []


def test_whoever_waits_for_a_sign_of_life_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "TOLD_S", 0.2)
    (tmp_path / NAME).mkdir()
    (tmp_path / NAME / "x.owner").write_text(
        json.dumps({**Owner("one", "far", 7, "another start", 0)._asdict(), "beat": 0})
    )
    said = []
    with owned(tmp_path, "two", "renders there", said.append):
        pass
    assert len(said) == 1 and f"process 7 on far owns {tmp_path} and may be dead" in said[0]


def test_what_is_no_file_owns_nothing(tmp_path):
    (tmp_path / NAME).mkdir()
    os.mkfifo(tmp_path / NAME / "x.owner")
    (tmp_path / NAME / "y.owner").mkdir()
    with ownership(tmp_path, "two"):
        pass


def test_one_that_sleeps_keeps_its_lock(tmp_path):
    with holder(tmp_path, "one") as process:
        os.kill(process.pid, signal.SIGSTOP)
        time.sleep(2)
        with pytest.raises(Owned), ownership(tmp_path, "two"):
            pass
        os.kill(process.pid, signal.SIGCONT)


@pytest.mark.parametrize("text", [b"", b"{", b"[]", b'{"group": "one"}', b"\xff" * 700])
def test_what_names_no_owner_is_silent_and_goes(tmp_path, text):
    (tmp_path / NAME).mkdir()
    (tmp_path / NAME / "x.owner").write_bytes(text)
    with ownership(tmp_path, "two"):
        pass
    assert os.listdir(tmp_path) == []


def test_half_made_files_of_the_dead_go(tmp_path):
    (tmp_path / NAME).mkdir()
    old, new = (tmp_path / NAME / f"{age}.new" for age in ("old", "new"))
    old.touch()
    new.touch()
    os.utime(old, (1, 1))
    with ownership(tmp_path, "two"):
        assert new.exists()
        assert not old.exists()


def entering(folder, group, inside, seen, turns):
    for _ in range(turns):
        with contextlib.suppress(Owned), ownership(folder, group):
            with inside[group].get_lock():
                inside[group].value += 1
            seen[group].value += 1
            others = [each.value for name, each in inside.items() if name != group]
            seen["both"].value += any(others)
            time.sleep(0.002)
            with inside[group].get_lock():
                inside[group].value -= 1


@pytest.mark.usefixtures("locks")
def test_two_groups_are_never_inside_at_once(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "SILENCE_S", 60)  # nobody dies here, and machines are slow
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


def test_the_lock_is_seen_by_others_before_the_file_is(tmp_path, monkeypatch):
    locked = []
    really = os.rename

    def renamed(source, target):
        really(source, target)
        if locked:
            return
        handle = os.open(target, os.O_RDWR)
        with pytest.raises(BlockingIOError):
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        os.close(handle)
        locked.append(target)

    monkeypatch.setattr(os, "rename", renamed)
    with ownership(tmp_path, "one"):
        assert len(locked) == 1
