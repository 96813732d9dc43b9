"""Presets and flags that are wrong: file, key and rule in one line, no traceback."""

import contextlib
import io
import json
import math
import random
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from bench.cli.flags import frame_numbers, preset_from_flags
from bench.cli.main import main
from lod.errors import InputError
from scenes.files import check_pattern
from scenes.presets.load import load_preset, preset_from, preset_names

GENERATED = 10_000
TABLE = "a table of keys"
FINITE = ("'high'", "nan", "inf", "-inf", "true", "[1.0]", "{ a = 1 }")
WHOLE = ("'many'", "1.5", "nan", "true", "[1]")
NO_TABLE = ("3", "'x'", "true", "[1]")
NO_LIST = ("3", "'x'", "true")

# key: values beside those of another kind, each outside the key's range
NUMBERS = {
    "camera.height": ("0", "-1", "1e7"),
    "camera.heading": ("-361", "360.5"),
    "camera.pitch": ("-91", "90.1"),
    "camera.fov": ("0", "180", "-60"),
    "camera.speed": ("-2e6", "2e6"),
    "camera.fps": ("0", "-24", "1001"),
    "view.detail": ("0", "-1", "1e7"),
    "view.offscreen_detail": ("0", "1.5", "-0.25"),
    "light.sun_azimuth": ("361", "-361"),
    "light.sun_elevation": ("0", "-5", "91"),
    "light.turbidity": ("0.9", "11"),
    "terrain.amplitude": ("-1", "2e4"),
    "terrain.hurst": ("0", "1.1"),
    "terrain.reach": ("1", "1e8"),
    "terrain.wavelength": ("1000", "0", "-4", "0.5"),
    "terrain.finest": ("0.3", "2", "0.001"),
    "species.elk.density": ("-1", "101"),
    "species.elk.patrol": ("-1", "1001"),
}
COUNTS = {
    "seed": ("-1", str(2**63)),
    "species.elk.prototypes": ("0", "-1", "257"),
    "render.spp": ("0", "-4", "65537"),
    "render.max_depth": ("0", "65"),
    "placed.fox.prototype": ("0", "257"),
}
OTHERS = {
    "camera": NO_TABLE,
    "view": NO_TABLE,
    "air": NO_TABLE,
    "light": NO_TABLE,
    "world": NO_TABLE,
    "terrain": NO_TABLE,
    "render": NO_TABLE,
    "output": NO_TABLE,
    "species": NO_TABLE,
    "species.elk": NO_TABLE,
    "placed": NO_TABLE,
    "camera.position": (*NO_LIST, "[1]", "[1, 2, 3]", "['a', 'b']", "[nan, 0]", "[1e16, 0]"),
    "camera.date": ("3", "true", "'noon'", "12:00:00", "2026-06-21T12:00:00Z", "'2026-13-01'"),
    "camera.cell": (*NO_LIST, "[1]", "[0.5, 0]", f"[{2**56}, 0]"),
    "camera.keys": (*NO_LIST, "[1]", "[{}]", "[{ frame = 1 }]"),
    "species.elk.sizes": (*NO_LIST, "[]", "[0]", "[-1]", "[1e4]", "['big']", "[nan]"),
    "species.elk.model": ("3", "'elk'", "''", "true", "[]"),
    "placed.fox.position": (*NO_LIST, "[]", "[1, inf]"),
    "placed.fox.size": ("0", "-1", "'big'", "1e9"),
    "placed.fox.walks": ("1", "'yes'", "[]"),
    "species.elk.dust": ("1", "'yes'", "[]", "true"),
    "placed.fox.heading": ("400", "'north'"),
    "view.metric": ("'blak'", "3", "true", "''", "'full'"),
    "view.look_around": ("1", "'yes'", "[]"),
    "air.visibility": ("'20'", "'-3km'", "'20 miles'", "0.5", "1e10", "nan", "true"),
    "world.extent": ("0", "-5", "1e16", "'wide'", "nan", "[]"),
    "render.size": ("'640'", "'0x0'", "'99999x9'", "'axb'", "[640]", "[0, 9]", "[1.5, 9]", "7"),
    "render.variant": ("3", "''", "true"),
    "output.compression": ("'lossy'", "3", "true"),
    "output.multipart": ("1", "'yes'"),
    "output.colour": ("'double'", "16"),
    "about": ("3", "true", "[]"),
    "colour": ("1", "'red'"),
    "camera.hieght": ("1", "'x'"),
    "species.elk.size": ("1", "[1]"),
}
REQUIRED = {
    "species": {"elk": {"model": "tree", "density": 0.1}},
    "placed": {"fox": {"model": "insect", "position": [0.0, 0.0]}},
}


def by_hand() -> list[tuple[str, str]]:
    """Every key with every value that it may not have."""
    numbers = [(key, value) for key, out in NUMBERS.items() for value in (*FINITE, *out)]
    counts = [(key, value) for key, out in COUNTS.items() for value in (*WHOLE, *out)]
    others = [(key, value) for key, values in OTHERS.items() for value in values]
    return [*numbers, *counts, *others]


def as_toml(data: dict[str, Any], prefix: str = "") -> Iterator[str]:
    """Nested data as lines of dotted keys."""
    for key, value in data.items():
        if isinstance(value, dict):
            yield from as_toml(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key} = {value if isinstance(value, str) else json.dumps(value)}"


def spoilt(key: str, value: str) -> str:
    """A whole preset in which one key has that value (TOML)."""
    data: dict[str, Any] = json.loads(json.dumps(REQUIRED))
    for name in ("elk", "fox"):
        kind = "species" if name == "elk" else "placed"
        data[kind][name]["model"] = json.dumps(data[kind][name]["model"])
    *path, last = key.split(".")
    inner = data
    for step in path:
        inner = inner.setdefault(step, {})
    inner[last] = value
    return "\n".join(as_toml(data)) + "\n"


def run(*arguments: str) -> tuple[int, str, str]:
    """The program in this process: code, stdout, stderr."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        with pytest.raises(SystemExit) as left:
            main(arguments)
    return left.value.code, out.getvalue(), err.getvalue()


def is_one_line(code: int, err: str) -> None:
    assert code in (1, 2), err
    assert err.startswith("lodbench: error: ") and err.count("\n") == 1, err
    assert "Traceback" not in err and "LODBENCH_TRACEBACK" not in err, err
    assert len(err) < 1000


def test_three_hundred_made_by_hand() -> None:
    assert len(set(by_hand())) == len(by_hand())
    assert len(by_hand()) >= 300


@pytest.mark.parametrize("depth", [150, 400, 3000])
@pytest.mark.parametrize("table", ["{} = 1", "[{}]\nx = 1", "[species.{}]\nx = 1"])
def test_tables_in_tables_in_tables_are_refused(depth: int, table: str, tmp_path: Path) -> None:
    path = tmp_path / "deep.toml"
    path.write_text(table.format(".".join("a" * depth)) + "\n")
    code, out, err = run("count", str(path))
    assert (code, out) == (2, "")
    is_one_line(code, err)


@pytest.mark.parametrize("key", [*NUMBERS, *COUNTS, *OTHERS])
def test_a_bad_value_is_blamed_on_its_file_and_key(
    key: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for value in [value for each, value in by_hand() if each == key]:
        Path("bad.toml").write_text(spoilt(key, value))
        tomllib.loads(Path("bad.toml").read_text())  # wrong as a preset, not as TOML
        code, out, err = run("count", "bad.toml")
        assert (code, out) == (2, ""), (value, err)
        is_one_line(code, err)
        where, arrived, rule = err.removeprefix("lodbench: error: bad.toml: ").split(": ", 2)
        assert where.startswith(key), (value, err)
        assert arrived and len(rule.strip()) > 4, (value, err)


# What no key may be, by what it is now.
_NEVER: dict[type, list[Any]] = {
    bool: [None, 3, "yes", [], math.nan],
    int: [{"x": 1}, "many", True, [[]], -1e300, math.nan],
    float: [{"x": 1}, "far", True, [[]], math.inf, -math.inf, math.nan],
    str: [{"x": 1}, 7.5e300, True, [[]], "\x00", "no such thing"],
    list: [{"x": 1}, "list", True, [[[]]], -1, [math.nan]],
}
_FREE_TEXT = {"about", "render.variant"}
_OF_BEHAVIOURS = {"behaviour", "options"}
"""Keys that mean what a behaviour says, which is only asked when the preset's actors act."""


def leaves(data: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in data.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def a_bad_preset(chance: random.Random, presets: list[dict[str, Any]]) -> tuple[Any, str]:
    """A preset in which one known key is spoilt, or one that is unknown stands; and that key."""
    data = json.loads(json.dumps(chance.choice(presets)))
    key, value = chance.choice([each for each in leaves(data) if _is_known(each[0])])
    *path, last = key.split(".")
    inner = data
    for step in path:
        inner = inner[step]
    if chance.random() < 0.2:
        last = "".join(chance.choices("abcdefgh_-é7", k=12))
        key = ".".join([*path, last])
    inner[last] = chance.choice(_NEVER.get(type(value), [{"x": 1}]))
    return data, key


def _is_known(key: str) -> bool:
    """Tell whether what a key may hold is known when a preset is read."""
    return key not in _FREE_TEXT and _OF_BEHAVIOURS.isdisjoint(key.split("."))


def an_odd_text(chance: random.Random) -> str:
    """Text of which some means something."""
    pieces = ["1", "-", ",", "0", "x", "km", "e9", "nan", ".", "=", "#", "####", "/", "\x00", "é"]
    pieces += ["figure", "species", "inf", "[", "]", "{", "'", '"', " ", "\n", "9" * 40, "exr"]
    return "".join(chance.choices(pieces, k=chance.randrange(1, 9)))


def spoil_somewhere(chance: random.Random, data: Any, depth: int = 0) -> Any:
    """The same nested data with one thing in it replaced or left out."""
    odd: list[Any] = [None, [], {}, "x", -1, 1.5, True, "../../etc", 10**40, [[[]]], "é\x00"]
    if not isinstance(data, dict) or not data or (depth and chance.random() < 0.3):
        return chance.choice(odd)
    key = chance.choice(list(data))
    copy = dict(data)
    if chance.random() < 0.2:
        copy.pop(key)
    elif chance.random() < 0.2:
        copy[chance.choice(["", "x", "../a.0001.exr", "/etc/a.exr", "é\x00.exr"])] = copy.pop(key)
    else:
        copy[key] = spoil_somewhere(chance, data[key], depth + 1)
    return copy


def scrambled(chance: random.Random, text: str) -> bytes:
    """Text with a few bytes changed, lost or added."""
    data = bytearray(text.encode())
    for _ in range(chance.randrange(1, 4)):
        at = chance.randrange(len(data))
        data[at : at + chance.randrange(3)] = chance.randbytes(chance.randrange(3))
    return bytes(data)


def tells(call: Callable[[], object]) -> None:
    """It may be right by chance; what is wrong has a place and a rule."""
    try:
        call()
    except InputError as error:
        assert error.where and len(error.rule) > 3


@pytest.mark.slow
def test_ten_thousand_generated_presets_and_flags(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    chance = random.Random(7)
    presets = [load_preset(name) for name, _ in preset_names()]
    tables = [preset.model_dump(mode="json") for preset in presets]
    for _ in range(GENERATED // 4):  # one key wrong
        data, key = a_bad_preset(chance, tables)
        with pytest.raises(InputError) as refused:
            preset_from(data, source="bad.toml")
        assert refused.value.where.startswith(f"bad.toml: {key.split('.')[0]}"), key
        assert len(refused.value.rule) > 3
    texts = [spoilt("seed", "3"), spoilt("camera.keys", "[]")]
    for _ in range(GENERATED // 4):  # bytes wrong
        Path("bad.toml").write_bytes(scrambled(chance, chance.choice(texts)))
        tells(lambda: load_preset("bad.toml"))
    for _ in range(GENERATED // 4):  # flags wrong
        text = an_odd_text(chance)
        flag = chance.choice(["size", "seed", "metric", "detail", "visibility", "spp", "variant"])
        tells(lambda flag=flag, text=text: preset_from_flags("meadow", (), (), **{flag: text}))
        tells(lambda text=text: preset_from_flags("meadow", (text,), (text,)))
        tells(lambda text=text: frame_numbers(text))
        tells(lambda text=text: check_pattern(text))
