"""Presets and flags that are wrong: file, key and rule in one line, no traceback."""

import contextlib
import io
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from bench.cli.main import main

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
