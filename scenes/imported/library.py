"""Reading the scene files that a user brings, keeping them by name, and finding those of presets.

A kept model is one file of this program's own: plain arrays, nothing that could be run. A preset
means its file or its name, held against the hash of what was meant.
"""

import io
import json
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from lod.errors import InputError
from lod.shapes import MeshTable, middles
from scenes.files import whole_file
from scenes.imported.gltf import read_gltf
from scenes.imported.part_tree import MESH_COLUMNS, OWN_COLUMNS, PartTree, Sidecar, build_tree
from scenes.imported.usd import read_usd
from scenes.model_files import (
    SUFFIXES,
    built_in_names,
    is_model_file,
    read_model_file,
    user_model_names,
    user_model_path,
)
from scenes.processes.cache import kept

_BROKEN = ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError
"""What libraries, and what is made of their results, meet in a file that is not as it must be."""

FORMAT = 1  # version of the file; one of another version is refused


def pack(tree: PartTree) -> bytes:
    """Write a model as the bytes of a .npz archive."""
    said = {"format": FORMAT, "names": tree.names, "period": tree.period}
    about = np.frombuffer(json.dumps(said).encode(), np.uint8)
    columns: dict[str, Any] = {"about": about, **tree.columns()}
    out = io.BytesIO()
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
            columns = {name: found[name] for name in MESH_COLUMNS}
            spine = middles(columns["first_vertex"], columns["vertices"])
            meshes = MeshTable(**columns, spine=spine)
            own = {name: found[name] for name in OWN_COLUMNS}
            return PartTree(names=tuple(said["names"]), meshes=meshes, **own, period=said["period"])
    except InputError:
        raise
    except Exception as error:  # damage may appear as any error at all
        rule = f"an imported model ({type(error).__name__})"
        raise InputError(where, f"{len(data)} bytes", rule, "add it again") from None


def read_model(path: Path, note: Callable[[str], object] = lambda text: None) -> PartTree:
    """Read a scene file and the table beside it; ``note`` hears what a renderer would show
    otherwise. Raises InputError for all that is wrong."""
    where = str(path)
    try:
        if not is_model_file(where):
            rule = f"a file that ends in {', '.join(SUFFIXES)}"
            raise InputError(where, path.suffix, rule, "export the scene as one of these")
        if not path.is_file():
            rule = "the path of a file that is there"
            raise InputError(where, path.name, rule, "see how it is spelt")
        if path.stat().st_size == 0:
            raise InputError(where, "0 bytes", "a scene file", "it is empty: export it again")
        beside = path.with_name(f"{path.name}.toml")
        sidecar = read_model_file(beside, Sidecar, {}) if beside.is_file() else Sidecar()
        if path.suffix.lower() in (".gltf", ".glb"):
            return build_tree(path.name, read_gltf(path, sidecar), sidecar)
        notes: list[str] = []
        tree = build_tree(path.name, read_usd(path, sidecar, notes.append), sidecar)
        for text in notes:
            note(text)
        return tree
    except InputError as error:
        if error.cure:
            raise
        cure = "mend it in the program that made the scene, and export it again"
        raise InputError(error.where, error.arrived, error.rule, cure) from None
    except _BROKEN as error:
        text = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        rule = f"a scene file that can be read ({text})"
        raise InputError(where, path.suffix, rule, "export it again") from None
    except ModuleNotFoundError as error:
        rule, cure = f"needs {error.name}", "pip install 'lodbench[models]'"
        raise InputError(where, path.suffix, rule, cure) from None
    except OSError as error:
        raise InputError(where, path.name, "a file that can be read", str(error.strerror)) from None


def user_model(name: str) -> PartTree:
    """Read a model that the user has added. Raises InputError where there is none."""
    path = user_model_path(name)
    if not path.is_file():
        rule = f"a model that was added: {', '.join(user_model_names()) or 'none was'}"
        raise InputError("NAME", name, rule, "see `lodbench model list`")
    return unpack(path.read_bytes(), str(path))


def place_of_model(name: str, overwrite: bool) -> Path:
    """Return where a model would be kept. Raises InputError for a name that is taken."""
    path = user_model_path(name)
    if name in built_in_names():
        raise InputError("NAME", name, "a name that no built-in model has", "say --name")
    if path.exists() and not overwrite:
        raise InputError("NAME", name, "a new name", "say --overwrite, or another --name")
    return path


def keep_model(name: str, tree: PartTree, overwrite: bool) -> Path:
    """Keep a model under a name. Raises InputError for a name that is taken."""
    path = place_of_model(name, overwrite)
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path, overwrite) as temporary:
        temporary.write_bytes(pack(tree))
    return path


def remove_model(name: str) -> None:
    """Remove a model that the user has added, and its picture; raises InputError without one."""
    path = user_model_path(name)
    if not path.is_file():
        user_model(name)
    path.unlink()
    path.with_suffix(".png").unlink(missing_ok=True)


def model_digest(where: str, model: str, folder: Path, expected: str | None) -> str:
    """Find the model that a preset in ``folder`` names, and return its SHA-256 in hexadecimal.

    What was read is kept in the cache, where other processes of this user find it by that hash.
    ``expected`` is what the preset says that the hash is. Raises InputError where it is another's,
    and where there is no such model: ``where`` names the key.
    """
    path = folder / model
    if is_model_file(model) and (path.exists() or expected is None):
        tree = read_model(path)
    elif expected is not None and (is_model_file(model) or model not in user_model_names()):
        return model_by_digest(where, model, expected).digest
    else:
        tree = user_model(model)
    found = tree.digest
    if expected not in (None, found):
        rule = f"the model whose SHA-256 is {expected[:12]}… (this is {found[:12]}…)"
        raise InputError(where, model, rule, "bring that back, or take model_sha256 out")
    _kept(found, tree)
    return found


@lru_cache(maxsize=32)
def model_by_digest(where: str, model: str, digest: str) -> PartTree:
    """Return the model of that hash: one that was added by that name, or read here before.

    Raises InputError where this machine has none.
    """
    if model in user_model_names():
        tree = user_model(model)
        if tree.digest == digest:
            return tree
    rule = f"the model whose SHA-256 is {digest[:12]}…, which is not on this machine"
    missing = InputError(where, model, rule, "bring it by `lodbench model add`")
    return _kept(digest, missing)


def _kept(digest: str, tree: PartTree | InputError) -> PartTree:
    """The model of that hash from the cache; an error is raised where it is not there."""

    def make() -> dict[str, np.ndarray]:
        if isinstance(tree, InputError):
            raise tree
        return {"model": np.frombuffer(pack(tree), np.uint8)}

    found = kept("models", digest, make, ("scenes.imported",))
    return unpack(found["model"].tobytes(), digest)
