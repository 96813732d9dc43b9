"""Streams that are closed, full or unread lose what is written to them, and nothing else."""

import os
import subprocess
import sys
import threading
import time

import pytest

from scenes.processes.standard_streams import (
    carry_failure,
    is_unread,
    lenient_stream,
    write_failure,
)

OPENED = """
import os, sys
from scenes.processes.standard_streams import open_standard_streams
open_standard_streams()
next_one = os.open(os.devnull, os.O_RDONLY)
print("words for nobody", flush=True)
print("and more", file=sys.stderr, flush=True)
child = os.system("echo from a child; echo and again >&2")
os._exit(0 if next_one > 2 and child == 0 else 1)
"""


@pytest.mark.parametrize("redirection", ["2>&-", ">&-", "<&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_what_is_closed_is_opened_and_its_number_given_to_no_file(redirection):
    script = f'"{sys.executable}" -c "$0" {redirection}'
    done = subprocess.run(["bash", "-c", script, OPENED], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_without_opening_it_the_next_file_takes_its_place():
    script = f'"{sys.executable}" -c "import os; os._exit(os.open(os.devnull, 0))" 2>&-'
    assert subprocess.run(["bash", "-c", script]).returncode == 2


@pytest.mark.parametrize("path", ["/dev/full", "/dev/null"])
def test_a_disk_that_is_full_is_remembered(path):
    number = os.open(path, os.O_WRONLY)
    with lenient_stream(number, closefd=True) as stream:
        for _ in range(3):
            print("words", file=stream, flush=True)
        failure = write_failure(stream)
    assert (failure.strerror if failure else None) == (
        "No space left on device" if path == "/dev/full" else None
    )
    assert not is_unread(failure)


def test_a_reader_that_went_away_is_another_matter():
    reads, writes = os.pipe()
    os.close(reads)
    with lenient_stream(writes, closefd=True) as stream, open(os.devnull, "w") as other:
        print("words", file=stream)
        assert is_unread(write_failure(stream))
        carry_failure(stream, other)  # a stream of another kind does not mind
        assert write_failure(other) is None


def test_one_stream_answers_for_another():
    with (
        lenient_stream(os.open("/dev/full", os.O_WRONLY), closefd=True) as ends,
        lenient_stream(os.open(os.devnull, os.O_WRONLY), closefd=True) as goes_on,
    ):
        print("words", file=ends)
        carry_failure(ends, goes_on)
        assert write_failure(goes_on) is write_failure(ends) is not None


def test_a_slow_reader_of_a_pipe_that_does_not_block_gets_every_byte():
    reads, writes = os.pipe()
    os.set_blocking(writes, False)
    read = []

    def read_slowly():
        time.sleep(0.2)
        while data := os.read(reads, 2**16):
            read.append(data)

    reader = threading.Thread(target=read_slowly)
    reader.start()
    with lenient_stream(writes, closefd=True) as stream:
        stream.write("x" * 1_000_000)
        assert write_failure(stream) is None
    reader.join()
    os.close(reads)
    assert b"".join(read) == b"x" * 1_000_000


def test_what_the_encoding_lacks_is_an_escape(capfd):
    with lenient_stream(os.dup(1), closefd=True) as stream:
        print("\udcff τ", file=stream)
    assert capfd.readouterr().out == "\\udcff τ\n"
