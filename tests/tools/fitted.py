"""Write what is fitted for the presets into the file that comes with the package.

``python -m tests.tools.fitted`` fills an empty cache with the first frame of every preset and packs
the entries of FITTED_KINDS. With ``--check`` it compares them with the file, which takes some ten
minutes; a slow test does so for one preset.
"""

import io
import os
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np

from scenes.presets.load import preset_names
from scenes.processes import cache

FILL = """
import sys
from pathlib import Path
from scenes.processes import cache
cache.FITTED = Path()
from scenes.scene import Scene
Scene(sys.argv[1]).input(1)
"""

_EPOCH = (1980, 1, 1, 0, 0, 0)  # so that equal arrays make equal files


def fill(preset: str, folder: Path) -> None:
    """Prepare a preset's first frame with a cache folder and nothing of what is shipped."""
    subprocess.run(
        [sys.executable, "-c", FILL, preset],
        env={**os.environ, cache.VARIABLE: str(folder)},
        check=True,
    )


def entries(folder: Path) -> dict[str, dict[str, np.ndarray]]:
    """Read the entries of FITTED_KINDS of a cache folder by kind and key, and name of array."""
    found = {}
    for kind in cache.FITTED_KINDS:
        for path in sorted(folder.glob(f"arrays/{kind}/*.arrays")):
            with np.load(path) as file:
                found[f"{kind}/{path.stem.split('-')[0]}"] = {
                    name: file[name] for name in file[cache._MEMBERS].tolist()
                }
    return found


def shipped() -> dict[str, dict[str, np.ndarray]]:
    """Read what comes with the package, as ``entries`` does."""
    known = cache._fitted().items()
    return {entry: cache._read_members(cache.FITTED, members) for entry, members in known}


def differing(made: dict[str, dict[str, np.ndarray]]) -> list[str]:
    """Name the entries that are not those that come with the package.

    Other machines differ in the last bits of what is grown, and so in a ray here and there.
    """
    known = shipped()
    return [
        entry
        for entry, arrays in made.items()
        if arrays.keys() != known.get(entry, {}).keys()
        or not all(
            np.allclose(values, known[entry][name], rtol=1e-3, atol=2e-3)
            for name, values in arrays.items()
        )
    ]


def write(found: dict[str, dict[str, np.ndarray]], path: Path) -> None:
    """Pack entries into a file."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
        for entry, arrays in sorted(found.items()):
            for name, values in sorted(arrays.items()):
                member = io.BytesIO()
                np.save(member, values)
                file.writestr(
                    zipfile.ZipInfo(f"{entry}/{name}.npy", _EPOCH),
                    member.getvalue(),
                    zipfile.ZIP_DEFLATED,
                    9,
                )


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        for each, _ in preset_names():
            print(each, flush=True)
            fill(each, Path(folder))
        made = entries(Path(folder))
    if sys.argv[1:] == ["--check"]:
        sys.exit("\n".join(differing(made)) or int(made.keys() != shipped().keys()))
    write(made, cache.FITTED)
    print(f"{cache.FITTED.name}: {cache.FITTED.stat().st_size / 1e6:.1f} MB")
