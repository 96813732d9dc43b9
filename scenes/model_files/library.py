"""Reading the scene files that a user brings, and keeping them as models by name."""

from pathlib import Path

from lod.errors import InputError
from scenes.model_files.build_tree import build_tree
from scenes.model_files.compiled import pack, read_compiled
from scenes.model_files.gltf import read_gltf
from scenes.model_files.names import built_in_names
from scenes.model_files.part_tree import PartTree
from scenes.model_files.sidecar import read_sidecar
from scenes.model_files.usd import read_usd
from scenes.model_files.user_models import (
    SUFFIXES,
    is_model_file,
    user_model_names,
    user_model_path,
)

_GLTF = (".gltf", ".glb")


_CURE = "mend it in the program that made the scene, and export it again"


def read_model(path: Path) -> PartTree:
    """Read a scene file and the table beside it; raises InputError for all that is wrong."""
    try:
        return _read_model(path)
    except InputError as error:
        if error.cure:
            raise
        raise InputError(error.where, error.arrived, error.rule, _CURE) from None


def _read_model(path: Path) -> PartTree:
    where = str(path)
    if not is_model_file(where):
        rule = f"a file that ends in {', '.join(SUFFIXES)}"
        raise InputError(where, path.suffix, rule, "export the scene as one of these")
    try:
        if not path.is_file():
            rule = "the path of a file that is there"
            raise InputError(where, path.name, rule, "see how it is spelt")
        if path.stat().st_size == 0:
            raise InputError(where, "0 bytes", "a scene file", "it is empty: export it again")
        sidecar = read_sidecar(path)
        read = read_gltf if path.suffix.lower() in _GLTF else read_usd
        nodes = read(path, sidecar)
    except ModuleNotFoundError as error:
        rule, cure = f"needs {error.name}", "pip install 'lodbench[models]'"
        raise InputError(where, path.suffix, rule, cure) from None
    except OSError as error:
        raise InputError(where, path.name, "a file that can be read", str(error.strerror)) from None
    return build_tree(path.name, nodes, sidecar)


def user_model(name: str) -> PartTree:
    """Read a model that the user has added. Raises InputError where there is none."""
    path = user_model_path(name)
    if not path.is_file():
        rule = f"a model that was added: {', '.join(user_model_names()) or 'none was'}"
        raise InputError("NAME", name, rule, "see `lodbench model list`")
    return read_compiled(path)


def keep_model(name: str, tree: PartTree, overwrite: bool) -> Path:
    """Keep a model under a name. Raises InputError for a name that is taken."""
    path = user_model_path(name)
    if name in built_in_names():
        raise InputError("NAME", name, "a name that no built-in model has", "say --name")
    if path.exists() and not overwrite:
        raise InputError("NAME", name, "a new name", "say --overwrite, or another --name")
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_bytes(pack(tree))
    part.replace(path)
    return path


def remove_model(name: str) -> None:
    """Remove a model that the user has added, and its picture; raises InputError without one."""
    path = user_model_path(name)
    if not path.is_file():
        user_model(name)
    path.unlink()
    path.with_suffix(".png").unlink(missing_ok=True)
