"""A parser of pbrt-v4's scenes, written from its format page (https://pbrt.org/fileformat-v4)."""

import gzip
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

TOKEN = re.compile(r'#[^\n]*|"[^"]*"|[\[\]]|[^\s\[\]"#]+')
NUMBERED = {"LookAt": 9, "Scale": 3, "Translate": 3, "Transform": 16, "Rotate": 4}
NAMED = {"ObjectBegin", "ObjectInstance", "Include"}
TYPED = {
    *("Camera", "Film", "PixelFilter", "Sampler", "Integrator", "LightSource", "Material", "Shape"),
    "Texture",
}
PLAIN = {"AttributeBegin", "AttributeEnd", "ObjectEnd", "WorldBegin"}


@dataclass
class Drawn:
    """A shape, with the transformation and the material that it was said under."""

    kind: str
    given: dict
    place: np.ndarray
    material: dict


@dataclass
class Scene:
    said: list = field(default_factory=list)
    shapes: list = field(default_factory=list)
    objects: dict = field(default_factory=dict)
    instances: list = field(default_factory=list)


def tokens(path: Path) -> Iterator[str]:
    data = path.read_bytes()
    text = (gzip.decompress(data) if path.suffix == ".gz" else data).decode()
    yield from (t for t in TOKEN.findall(text) if not t.startswith("#"))


def parse(path: Path) -> Scene:
    scene = Scene()
    _read(path, scene)
    return scene


def _read(path: Path, scene: Scene) -> None:
    words = list(tokens(path))
    at, place, material, stack, into = 0, np.eye(4), {}, [], scene.shapes

    def parameters(at: int) -> tuple[dict, int]:
        found = {}
        while at < len(words) and words[at].startswith('"'):
            kind, name = words[at].strip('"').split()
            if words[at + 1] == "[":
                end = words.index("]", at + 1)
                values, at = words[at + 2 : end], end + 1
            else:
                values, at = [words[at + 1]], at + 2
            texts = kind in ("string", "texture")
            found[name] = [v.strip('"') for v in values] if texts else np.array(values, float)
        return found, at

    while at < len(words):
        word = words[at]
        at += 1
        if word in NUMBERED:
            numbers = [w for w in words[at : at + NUMBERED[word] + 2] if w not in "[]"]
            at += NUMBERED[word] + 2 * (words[at] == "[")
            values = np.array(numbers[: NUMBERED[word]], float)
            if word == "Transform":
                place = values.reshape(4, 4).T
            elif word == "Translate":
                move = np.eye(4)
                move[:3, 3] = values
                place = place @ move
            scene.said.append((word, values))
        elif word in NAMED:
            name = words[at].strip('"')
            at += 1
            if word == "Include":
                _read(path.parent / name, scene)
            elif word == "ObjectBegin":
                stack.append((place, material))
                into = scene.objects.setdefault(name, [])
            else:
                scene.instances.append((name, place))
        elif word in TYPED:
            kind = words[at].strip('"')
            at += 1 + 2 * (word == "Texture")
            given, at = parameters(at)
            if word == "Material":
                material = given
            elif word == "Shape":
                into.append(Drawn(kind, given, place, material))
            else:
                scene.said.append((word, kind, given))
        else:
            assert word in PLAIN, word
            if word == "AttributeBegin":
                stack.append((place, material))
            elif word in ("AttributeEnd", "ObjectEnd"):
                place, material = stack.pop()
                into = scene.shapes if word == "ObjectEnd" else into


def points(shape: Drawn) -> np.ndarray:
    """Lowest and highest corner of a shape, (2, 3)."""
    if shape.kind == "sphere":
        r = shape.given["radius"][0]
        return shape.place[:3, 3] + r * np.array((-np.ones(3), np.ones(3)))
    p = shape.given["P"].reshape(-1, 3)
    return np.array((p.min(axis=0), p.max(axis=0)))
