"""In a container of a user without a home, where nothing but -o can be written to, frames come."""

import hashlib
import json
import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

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
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("no writable folder for compiled kernels") == 1
    assert sorted(path.name for path in out.iterdir()) == [
        *("a.0001.exr", "a.0002.exr", "manifest.json")
    ]
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
    done = as_nobody(out, "doctor", "--json", **variables)
    assert done.returncode == 0, done.stderr
    kernels = json.loads(done.stdout)["kernels"]
    assert kernels == {"folder": None, "kept": False, "temporary": None}
    assert "lodbench: no writable folder for compiled kernels" in done.stderr
