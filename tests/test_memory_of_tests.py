"""A test that runs away with memory fails by itself, and takes no others with it."""

import mmap
import resource
import subprocess
import sys

import numpy as np
import pytest

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="others limit other things")
LIMIT, _ = resource.getrlimit(resource.RLIMIT_DATA)
TOO_MUCH = f"import numpy; numpy.empty({2 * LIMIT}, numpy.uint8)"


def test_what_no_process_may_take_is_refused() -> None:
    """Nothing of it is written to, so that a machine without the limit survives the failure."""
    with pytest.raises(MemoryError):
        np.empty(2 * LIMIT, np.uint8)


def test_processes_that_a_test_starts_are_limited_too() -> None:
    done = subprocess.run([sys.executable, "-c", TOO_MUCH], capture_output=True, text=True)
    assert done.returncode == 1
    assert "MemoryError" in done.stderr


def test_what_is_only_kept_is_not_limited() -> None:
    private = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS
    with mmap.mmap(-1, 2 * LIMIT, private, mmap.PROT_READ) as kept:
        assert len(kept) == 2 * LIMIT
