"""This package has scenes and makes pixels of it: field, presets, rendering.

Only ``scenes.render`` imports a renderer. Dr.Jit, of which ``lod`` takes quaternions, loads libLLVM
as soon as it is imported, the system's where no other is named: so the environment's is named here.
Where a caller has imported Dr.Jit before, the library that it has loaded is the one to be tried.
"""

import os
import re
import site
import sys
from contextlib import suppress
from pathlib import Path

LLVM_PATH = "DRJIT_LIBLLVM_PATH"


def packaged_library() -> Path | None:
    """Path of the libLLVM that the package karellen-llvm-core brings into the environment, or None.

    It is found without the links that are made when Python first starts in the environment.
    """
    bases = (sys.prefix, site.getuserbase() if site.ENABLE_USER_SITE else sys.prefix)
    found = (each for base in bases for each in sorted(Path(base, "lib").glob("libLLVM.so.*")))
    return next((each.resolve() for each in found if each.is_file()), None)


def loaded_library() -> Path | None:
    """Path of the libLLVM that is loaded already; None without one, or where nothing tells."""
    with suppress(OSError):
        maps = Path("/proc/self/maps").read_text(encoding="utf-8", errors="replace")
        return next(iter(map(Path, re.findall(r"(/.*/libLLVM[^/\n]*)$", maps, re.M))), None)
    return None


if LLVM_PATH not in os.environ and (named := loaded_library() or packaged_library()):
    os.environ[LLVM_PATH] = str(named)
