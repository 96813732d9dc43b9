"""Which model does a preset mean: its file or its name, held against the hash of what was meant."""

from functools import lru_cache
from pathlib import Path

import numpy as np

from lod.errors import InputError
from scenes.model_files.compiled import pack, unpack
from scenes.model_files.library import read_model, user_model
from scenes.model_files.part_tree import PartTree
from scenes.model_files.user_models import is_model_file, user_model_names
from scenes.processes.content_cache import kept


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
    return _kept(
        digest,
        InputError(
            where,
            model,
            f"the model whose SHA-256 is {digest[:12]}…, which is not on this machine",
            "bring it by `lodbench model add`",
        ),
    )


def _kept(digest: str, tree: PartTree | InputError) -> PartTree:
    """The model of that hash from the cache; an error is raised where it is not there."""

    def make() -> dict[str, np.ndarray]:
        if isinstance(tree, InputError):
            raise tree
        return {"model": np.frombuffer(pack(tree), np.uint8)}

    found = kept("models", digest, make, ("scenes.model_files",))
    return unpack(found["model"].tobytes(), digest)
