"""Pictures that a record holds, so that the report can lay them over each other.

A record names them under ``notes["pictures"]``: small WebP files as base64 text, inside the record
and so under its hash.
"""

import base64
import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image

from bench.records.records import Record
from lod.errors import InputError

NOTE = "pictures"


@dataclass(frozen=True)
class Pictures:
    """Pictures of one view and one size; ``layers`` are their names and WebP files in base64."""

    name: str
    title: str
    caption: str
    alt: str
    layers: tuple[tuple[str, str], ...]


def pictures(
    name: str, words: tuple[str, str, str], layers: Mapping[str, np.ndarray], quality: int = 80
) -> dict[str, Any]:
    """Return pictures as a record's notes hold them.

    words   title, caption and text alternative
    layers  display pictures by name, (h, w, 3) uint8, all of one size

    Raises InputError for fewer than two pictures, other sizes and other types.
    """
    shapes = {picture.shape for picture in layers.values()}
    if len(layers) < 2 or len(shapes) != 1 or any(p.dtype != np.uint8 for p in layers.values()):
        raise InputError(f"pictures {name}", sorted(shapes), "two or more of one size, uint8")
    title, caption, alt = words
    coded = [[label, _webp(picture, quality)] for label, picture in layers.items()]
    return {"name": name, "title": title, "caption": caption, "alt": alt, "layers": coded}


def pictures_of(record: Record) -> tuple[Pictures, ...]:
    """Return the pictures that a record holds, in their order."""
    return tuple(
        Pictures(**{**each, "layers": tuple((label, data) for label, data in each["layers"])})
        for each in record.notes.get(NOTE, ())
    )


def _webp(picture: np.ndarray, quality: int) -> str:
    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, "WEBP", quality=quality)
    return base64.b64encode(stream.getvalue()).decode()
