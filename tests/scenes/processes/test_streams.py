"""Streams that are closed, full or unread lose what is written to them, and nothing else.

A user without a home, who can write nowhere but to -o, gets the same frames.
"""

import hashlib
import json
import os
import subprocess
import sys
import sysconfig
import threading
import time
from pathlib import Path

import pytest

from scenes.processes.streams import carry_failure, is_unread, lenient_stream, write_failure

OPENED = """
import os, sys
from scenes.processes.streams import open_standard_streams
open_standard_streams()
next_one = os.open(os.devnull, os.O_RDONLY)
print("words for nobody", flush=True)
print("and more", file=sys.stderr, flush=True)
child = os.system("echo from a child; echo and again >&2")
os._exit(0 if next_one > 2 and child == 0 else 1)
"""


@pytest.mark.parametrize("redirection", ["2>&-", ">&-", "<&- >&- 2>&-"])
def test_what_is_closed_is_opened_and_its_number_given_to_no_file(redirection):
    script = f'"{sys.executable}" -c "$0" {redirection}'
    done = subprocess.run(["bash", "-c", script, OPENED], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


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


ROOT = Path(__file__).resolve().parents[3]
PRESET = "/opt/source/tests/bench/cli/tiny.toml"
CONTAINER = """
set -e
mount --make-rprivate /
mount --bind "$OUT" /mnt
mount -t tmpfs -o mode=0755 tmpfs /opt
mkdir /opt/python /opt/packages /opt/source
mount --bind "$PYTHON" /opt/python
mount --bind "$PACKAGES" /opt/packages
mount --bind "$SOURCE" /opt/source
for place in /opt/python /opt/packages /opt/source /opt; do
  mount -o remount,ro,bind $place
done
for place in /tmp /var/tmp /dev/shm /run; do
  mount -t tmpfs -o ro,size=64k tmpfs $place
done
cd /
exec setpriv --reuid=65534 --regid=65534 --clear-groups --bounding-set=-all \
  env -i PATH=/usr/bin:/bin PYTHONPATH=/opt/source:/opt/packages "$@"
"""


def as_nobody(out: Path, *words: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run the program as nobody, on a read-only system, with ``out`` at /mnt."""
    places = {
        "OUT": str(out),
        "PYTHON": sys.base_prefix,
        "PACKAGES": sysconfig.get_paths()["purelib"],
        "SOURCE": str(ROOT),
    }
    python = f"/opt/python/bin/python{sys.version_info.major}.{sys.version_info.minor}"
    program = [*(f"{name}={value}" for name, value in variables.items()), python, "-P", "-m"]
    return subprocess.run(
        ["unshare", "--mount", "sh", "-c", CONTAINER, "sh", *program, "bench.cli.main", *words],
        env={**os.environ, **places},
        capture_output=True,
        text=True,
        timeout=900,
    )


def can_be_tried() -> bool:
    """Whether this process may mount what it likes and become nobody."""
    tried = "mount --make-rprivate / && setpriv --reuid=65534 --clear-groups true"
    try:
        words = ["unshare", "--mount", "sh", "-c", tried]
        return subprocess.run(words, capture_output=True).returncode == 0
    except FileNotFoundError:
        return False


pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not can_be_tried(), reason="only root may make a container by hand"),
]


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """A folder that anybody may write to."""
    folder = tmp_path / "out"
    folder.mkdir()
    folder.chmod(0o777)
    return folder


def test_nothing_but_the_frames_folder_can_be_written_to(out: Path, tmp_path: Path) -> None:
    frames = "-o", "/mnt/a.####.exr", "--frames", "1-2", "--json"
    done = as_nobody(out, "render", PRESET, *frames)
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert "TMPDIR: None: a folder for temporary files" in done.stderr
    done = as_nobody(out, "render", PRESET, *frames, TMPDIR="/mnt")
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("no writable folder for compiled kernels") == 1
    assert sorted(path.name for path in out.iterdir()) == ["a.0001.exr", "a.0002.exr"]
    here = [sys.executable, "-P", "-m", "bench.cli.main", "render", str(ROOT / PRESET[12:])]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run(
        [*here, "-o", "a.####.exr", "--frames", "1-2"], cwd=tmp_path, env=environment, check=True
    )
    for record in map(json.loads, done.stdout.splitlines()[:2]):
        alike = tmp_path / Path(record["path"]).name
        assert record["sha256"] == hashlib.sha256(alike.read_bytes()).hexdigest()


@pytest.mark.parametrize("variables", [{}, {"NUMBA_CACHE_DIR": "/proc/no", "HOME": "/nonexistent"}])
def test_doctor_knows(out: Path, variables: dict[str, str]) -> None:
    done = as_nobody(out, "doctor", "--json", TMPDIR="/mnt", **variables)
    assert done.returncode == 0, done.stderr
    kernels = json.loads(done.stdout)["kernels"]
    assert kernels["folder"].startswith("/mnt/") and not kernels["kept"]
    assert "lodbench: no writable folder for compiled kernels" in done.stderr
