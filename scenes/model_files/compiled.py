"""An imported model as one file of this program's own: plain arrays, nothing that could be run."""

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from lod.errors import InputError
from lod.shapes import MeshTable
from scenes.model_files.part_tree import PartTree

FORMAT = 1
"""Version of the file; one of another version is refused."""

_MESH = ("first_vertex", "first_face", "vertices", "normals", "colours", "faces")
_OWN = ("parent", "level", "frame", "axis", "turns", "swing")


def pack(tree: PartTree) -> bytes:
    """Write a model as the bytes of a .npz archive."""
    said = {"format": FORMAT, "names": tree.names, "period": tree.period}
    about = np.frombuffer(json.dumps(said).encode(), np.uint8)
    out = io.BytesIO()
    columns: dict[str, Any] = {"about": about, **tree.columns()}
    np.savez_compressed(out, **columns)
    return out.getvalue()


def unpack(data: bytes, where: str) -> PartTree:
    """Read a model from such bytes. Raises InputError where they are none: ``where`` names them."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as found:
            said = json.loads(found["about"].tobytes())
            if said["format"] != FORMAT:
                rule = f"format {FORMAT} of an imported model"
                raise InputError(where, f"format {said['format']}", rule, "add it again")
            meshes = MeshTable(*(found[name] for name in _MESH))
            own = {name: found[name] for name in _OWN}
            return PartTree(names=tuple(said["names"]), meshes=meshes, **own, period=said["period"])
    except (KeyError, OSError, EOFError, TypeError, zipfile.BadZipFile) as error:
        rule = f"an imported model ({type(error).__name__})"
        raise InputError(where, f"{len(data)} bytes", rule, "add it again") from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(where, f"{len(data)} bytes", "an imported model", "add it again") from None


def read_compiled(path: Path) -> PartTree:
    """Read a model from such a file."""
    return unpack(path.read_bytes(), str(path))
