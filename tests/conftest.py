"""What holds under test only: checked shapes and types, a limit on memory, Hypothesis's search."""

import importlib
import os
import shutil
import signal
import sys
from contextlib import suppress
from pathlib import Path

import jaxtyping._import_hook as import_hook
import psutil
from hypothesis import settings
from jaxtyping import install_import_hook

# FLIP's threads wait by spinning: beside other workers that takes a hundred times as long.
os.environ.setdefault("OMP_NUM_THREADS", "1")

# Tests send it to children, who would inherit that it is ignored, as it is under nohup; what a
# process does of its own they do not inherit.
signal.signal(signal.SIGHUP, lambda number, frame: None)

# One cache for all workers and the commands they start. What a session before it made is gone: an
# entry must not hide that the code which makes it no longer works.
CACHE = Path(__file__).resolve().parents[1] / ".pytest_cache" / "lodbench"
if "PYTEST_XDIST_WORKER" not in os.environ:
    shutil.rmtree(CACHE / "arrays", ignore_errors=True)
os.environ["LODBENCH_CACHE"] = str(CACHE)

# What a command prints does not depend on how busy the machine is.
os.environ["LODBENCH_SIGN_OF_LIFE"] = "0"


def limit_memory() -> None:
    """Let each process of the tests write to a share of the machine's memory, and no more.

    The shares of two workers are more than there is: no two tests run away at once. One that does
    then fails with MemoryError, where the system would kill the process, and with it all the tests
    that it has still to run. Address space that is only kept, as compilers and browsers do, is not
    limited (RLIMIT_DATA of Linux).
    """
    with suppress(ImportError):
        import resource

        share = int(MEMORY_SHARE * psutil.virtual_memory().total)
        _, hard = resource.getrlimit(resource.RLIMIT_DATA)
        most = share if hard == resource.RLIM_INFINITY else min(share, hard)
        resource.setrlimit(resource.RLIMIT_DATA, (most, hard))


MEMORY_SHARE = 0.7
limit_memory()

ROOMS = ("lod", "scenes", "bench")

# An int may stand for a float, as PEP 484 and mypy have it; beartype alone would refuse it.
CHECKER = "beartype.beartype(conf=beartype.BeartypeConf(is_pep484_tower=True))"

COMPILED_BY = {"njit", "jit", "vectorize", "guvectorize", "cfunc"}


def leave_numba_alone() -> None:
    """Have the hook pass over functions that numba compiles: it cannot compile a wrapper."""
    skips = import_hook._is_no_type_check

    def skips_numba_too(decorator) -> bool:
        # Also reached from within `skips`, which unwraps @njit(...) to njit.
        name = getattr(decorator, "attr", getattr(decorator, "id", None))
        return skips(decorator) or name in COMPILED_BY

    import_hook._is_no_type_check = skips_numba_too


already_imported = [room for room in ROOMS if room in sys.modules]
if already_imported:
    raise RuntimeError(f"{already_imported} imported before its annotations could be checked")
leave_numba_alone()
install_import_hook(ROOMS, CHECKER)
importlib.import_module(
    "scenes"
)  # names the libLLVM of the environment, before Dr.Jit loads another

# A shared machine is slow at times: no deadline. CI must not find something new by chance.
settings.register_profile("local", deadline=None, max_examples=30)
settings.register_profile("ci", deadline=None, max_examples=30, derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "local")
