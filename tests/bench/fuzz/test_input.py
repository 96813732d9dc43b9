"""Whatever arrives is taken, or refused with its rule and a cure: presets, flags, files, plug-ins.

What the program itself wrote and somebody changed (records, journals, caches, models) is taken as
it was, made again, or refused; and no record leads to a path outside its report.

`LODBENCH_FUZZ=100000 python -m pytest tests/bench/fuzz -m "slow or not slow"` tries so many
cases in process, shared out among the kinds of input, and 500 in whole programs; without it a few
hundred are tried. `LODBENCH_FUZZ_RECORD=FILE` writes how many of each kind were taken and refused.
"""

import base64
import contextlib
import importlib
import io
import json
import os
import re
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, example, given, settings
from hypothesis import strategies as st
from numba.core import config

from bench import runs
from bench.cli import main as cli
from bench.cli.commands.render import command as render
from bench.cli.flags import FLAG_KEYS, frame_numbers, preset_from_flags
from bench.cli.main import _verdict as main_verdict
from bench.cli.main import main, program
from bench.records.claims import Claim
from bench.records.provenance import provenance
from bench.records.records import (
    FORMAT,
    FORMAT_VERSION,
    Record,
    content_sha256,
    merge_points,
    point_from_json,
    read_record,
)
from bench.report.document import Section
from bench.report.pages import to_markdown
from bench.report.write import _beside, _section_or_why
from bench.runs import Journal, RunRequest
from lod.errors import InputError
from lod.metric import Metric
from scenes import plugins as entry_points
from scenes.files import check_pattern
from scenes.imported.library import pack, read_model, unpack
from scenes.presets.load import known_keys, load_preset, preset_from, preset_names
from scenes.processes.cache import kept_data
from scenes.render.exr.frames_on_disk import read_whole
from tests.scenes.imported.sample_models import glb, lamp_tree_parts, mill

KINDS = 10
CASES = int(os.environ.get("LODBENCH_FUZZ", "600")) // KINDS
PROGRAMS = 500 if "LODBENCH_FUZZ" in os.environ else 20
fuzzed = settings(
    max_examples=CASES,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
    database=None,
)

NUMBERS = st.one_of(
    st.integers(-(2**70), 2**70),
    st.floats(),
    st.sampled_from([0, 1, -1, 0.0, -0.0, 1e-9, 1e-320, 5e-324, 1e308, 2**31, 2**63, 2**64]),
)
TEXTS = st.one_of(
    st.text(max_size=12),
    st.sampled_from(["", "clear", "20km", "1e400m", "-1m", "0x0", "16384x16384", "blake", "auto"]),
)
VALUES = st.recursive(
    st.one_of(NUMBERS, TEXTS, st.booleans(), st.none()),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(TEXTS, inner, max_size=3)),
    max_leaves=6,
)
MODELS = {"model": "figure", "density": 0.01}
TABLES = ("camera", "species", "species.elk", "placed", "output", "representations.x")
KEYS = known_keys({"species": ("elk",), "placed": ("fox",), "plumes": ("smoke",)})


COUNTS: Counter[str] = Counter()


@pytest.fixture(scope="module", autouse=True)
def record(request: pytest.FixtureRequest) -> Iterator[None]:
    """Write what was tried, where that is asked for and nothing failed on the way."""
    yield
    place = os.environ.get("LODBENCH_FUZZ_RECORD")
    if place and not request.session.testsfailed:
        found = {"commit": provenance("", 0).commit, "cases": dict(sorted(COUNTS.items()))}
        Path(place).write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def note(how: str) -> None:
    """Count a case of the test that runs now."""
    name = os.environ["PYTEST_CURRENT_TEST"].rpartition("::test_")[2].split()[0]
    COUNTS[f"{name}: {how}"] += 1


def judge(work: Callable[[], Any]) -> bool:
    """Whether input is taken; what is refused must name a rule and a cure in one short line."""
    try:
        work()
    except InputError as error:
        assert error.rule.strip() and error.cure.strip(), f"no cure: {error}"
        assert len(str(error)) < 1200 and "Traceback" not in str(error)
        str(error).encode("utf-8", "strict")
        note("refused")
        return False
    note("taken")
    return True


def laid(keys: dict[str, Any]) -> dict[str, Any]:
    """Dotted keys as tables, over a preset with a species."""
    tables: dict[str, Any] = {"species": {"elk": dict(MODELS)}}
    for key, value in keys.items():
        *path, name = key.split(".")
        inner = tables
        for step in path:
            inner = inner.setdefault(step, {})
            if not isinstance(inner, dict):
                break
        else:
            inner[name] = value
    return tables


@fuzzed
@given(st.dictionaries(st.one_of(st.sampled_from([*TABLES, *KEYS]), TEXTS), VALUES, max_size=5))
@example({"camera.keys": [{"frame": 5}, {"frame": 5}]})
@example({"species.elk.density": 1e-320})
def test_presets(keys: dict[str, Any]) -> None:
    judge(lambda: preset_from(laid(keys)))


@fuzzed
@given(st.sampled_from([name for name, _ in preset_names()]), st.data())
def test_preset_files(name: str, data: st.DataObject) -> None:
    """A shipped file with some characters changed."""
    shelf = Path(entry_points.__file__).parent / "presets"
    text = mutated((shelf / f"{name}.toml").read_text(encoding="utf-8"), data)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.toml"
        path.write_text(text, encoding="utf-8", errors="surrogatepass")
        judge(lambda: load_preset(str(path)))


WORDS = st.one_of(
    TEXTS,
    NUMBERS.map(str),
    st.sampled_from(["1-24", "9-1", "1,5", "1-9x2", "1-1000000", "o/\udcff.####.exr"]),
    st.tuples(st.sampled_from(KEYS), VALUES).map(lambda pair: f"{pair[0]}={pair[1]}"),
    st.tuples(TEXTS, NUMBERS).map(lambda pair: f"{pair[0]}={pair[1]}"),
)
FLAGS = st.sampled_from([each.opts[0] for each in render.params if each.opts[0].startswith("-")])


@fuzzed
@given(st.lists(st.one_of(WORDS, st.tuples(FLAGS, WORDS)), max_size=6))
def test_flags(words: list[str | tuple[str, str]]) -> None:
    flat = [each for word in words for each in ((word,) if isinstance(word, str) else word)]

    def parse() -> None:
        with contextlib.redirect_stdout(io.StringIO()):
            line = ["crowd", "-o", "a.####.exr", *flat]
            flags = render.make_context("render", line, **program.context_settings).params
        check_pattern(flags["pattern"])
        frame_numbers(flags["frames"])
        told = {name: value for name, value in flags.items() if name in FLAG_KEYS}
        preset_from_flags(flags["preset"], flags["settings"], flags["density"], **told)

    try:
        judge(parse)
    except (click.UsageError, click.exceptions.Exit):
        note("refused by the parser")


def changed(data: Any, draw: Callable[[Any], Any]) -> Any:
    """The same nested data with one value replaced, left out or of another kind."""
    if isinstance(data, dict) and data and draw(st.integers(0, 5)):
        key = draw(st.sampled_from(sorted(data)))
        if not draw(st.integers(0, 4)):
            return {k: v for k, v in data.items() if k != key}
        return {**data, key: changed(data[key], draw)}
    if isinstance(data, list) and data and draw(st.integers(0, 5)):
        at = draw(st.integers(0, len(data) - 1))
        return [*data[:at], changed(data[at], draw), *data[at + 1 :]]
    return draw(VALUES)


HOSTILE = st.one_of(
    VALUES, st.sampled_from(["../up", "/etc/passwd", "<script>", "a\nb", "\x1b[2J"])
)
POINT = {
    "case": {"x": 1},
    "predicted": [{"quantity": "parts", "value": 2.0, "keys": {}}],
    "samples": [{"quantity": "parts", "values": [1, 2], "keys": {"air": "hazy"}}],
    "scene": "",
}
PICTURES = {"name": "view", "title": "t", "caption": "c", "alt": "a", "layers": [["one", "AAAA"]]}
MADE = {"case": "1", "seconds": 1.0, "processor_seconds": 1.0}


@cache
def a_record() -> dict[str, Any]:
    claim = Claim("Parts", "≤", 2.0, 0.0, {"x": 1}, "field", "§2.4", 1.5, 1.0, 2.0)
    origin, notes = provenance("0" * 64, 0), {"pictures": [PICTURES]}
    whole = Record("old", 1, True, "2026-01-01", origin, (), (claim,), notes)
    return {**whole.content, "points": [POINT]}


@fuzzed
@given(st.data())
def test_records(data: st.DataObject) -> None:
    """Edited, and sealed again, as one would who knows how; what is taken is shown in a report."""
    content = a_record()
    for _ in range(data.draw(st.integers(0, 2))):
        content = changed(content, lambda of: data.draw(HOSTILE if of is VALUES else of))
    try:
        seal = content_sha256(json.loads(json.dumps(content)))
    except ValueError:  # a number that is not finite, which JSON has not
        seal = "0" * 64
    name = content.get("experiment") if isinstance(content, dict) else None
    with tempfile.TemporaryDirectory() as text:
        body = {"format": FORMAT, "format_version": FORMAT_VERSION, "sha256": seal}
        plain = isinstance(name, str) and re.fullmatch(r"[\w-]{1,40}", name)
        path = Path(text) / f"{name if plain else 'old'}-{seal[:16]}.json"
        path.write_text(json.dumps({**body, "content": content}), encoding="utf-8")
        if judge(lambda: read_record(path)):
            section = _section_or_why(path)
            if isinstance(section, Section):
                assert "<script" not in to_markdown([section])
                assert all(len(Path(name).parts) <= 2 for name in _beside([section]))


@fuzzed
@given(st.data())
def test_journals(data: st.DataObject) -> None:
    """A kept case of another content, well sealed or not, is one of points or measured again."""
    with tempfile.TemporaryDirectory() as folder:
        kept_case = changed({"points": [POINT], "made": MADE}, data.draw)
        path, asked = Path(folder) / "case.json", RunRequest("old", ("old",))
        try:
            runs._write(path, kept_case)
        except ValueError:
            path.write_text(json.dumps(kept_case))
        path.write_text(
            mutated(path.read_text(), data) if data.draw(st.booleans()) else path.read_text()
        )
        found = runs._case(path)
        note("taken" if found else "made again")
        merge_points(map(point_from_json, found["points"] if found else ()))
        journal = Journal(Path(folder) / "in", "maker")
        runs._write(journal._path("record", asked), data.draw(TEXTS.map(lambda text: f"../{text}")))
        assert journal.record_of(asked) is None


def mutated(text: str, data: st.DataObject) -> str:
    """A text with some characters changed."""
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text)))
        text = text[:at] + data.draw(TEXTS) + text[at + data.draw(st.integers(0, 6)) :]
    return text.encode("utf-8", "replace").decode()


def damaged(body: bytes, data: st.DataObject, most: int = 2**30) -> bytes:
    """Bytes of which a few of the first ``most`` are changed, or cut off."""
    found = bytearray(body)
    for _ in range(data.draw(st.integers(1, 4))):
        found[data.draw(st.integers(0, most)) % len(found)] = data.draw(st.integers(0, 255))
    return bytes(found[: data.draw(st.one_of(st.just(len(body)), st.integers(0, len(body))))])


@fuzzed
@given(st.data())
def test_arrays_of_the_cache(data: st.DataObject) -> None:
    made = "m", (np.arange(6.0), "text")
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.setenv("LODBENCH_CACHE", folder)
        kept_data("tree", "a", lambda: made, ("lod.errors",))
        (path,) = Path(folder).glob("arrays/*/*")
        path.write_bytes(damaged(path.read_bytes(), data))
        again: list[object] = []
        found = kept_data("tree", "a", lambda: again.append(1) or made, ("lod.errors",))
        note("made again" if again else "taken")
        assert found[0] == made[0] and found[1][1] == "text"
        assert np.array_equal(found[1][0], made[1][0])


@pytest.fixture(scope="module")
def kernel(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, dict[Path, bytes]]:
    """A compiled function and the files of its cache."""
    folder = tmp_path_factory.mktemp("kernel")
    source = folder / "double.py"
    source.write_text(
        "from lod.kernels import njit\n@njit(cache=True)\ndef double(x): return 2 * x"
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(config, "CACHE_DIR", str(folder / "cache"))
        patch.syspath_prepend(str(folder))
        double = importlib.import_module("double").double
        assert double(1) == 2
    return double, {path: path.read_bytes() for path in folder.rglob("*.nb?")}


@fuzzed
@given(st.data())
def test_kernels(kernel: tuple[Any, dict[Path, bytes]], data: st.DataObject) -> None:
    """What is given back of a damaged cache is the same code, or nothing."""
    double, files = kernel
    for path, whole in files.items():
        path.write_bytes(damaged(whole, data) if data.draw(st.booleans()) else whole)
    found = double._cache.load_overload(double.signatures[0], double.targetctx)
    note("taken" if found is not None else "made again")
    assert found is None or found.signature == double.nopython_signatures[0]


@pytest.mark.slow
@fuzzed
@given(st.sampled_from(["usda", "glb", "gltf", "toml", "npz"]), st.data())
def test_models(models: Path, suffix: str, data: st.DataObject) -> None:
    """Scene files with characters, entries or bytes changed, the table beside, and kept models."""
    whole = (models / f"mill.{suffix}").read_bytes()
    if suffix == "usda" or suffix == "toml":
        body = mutated(whole.decode(), data).encode()
    elif suffix == "gltf":
        body = json.dumps(changed(json.loads(whole), data.draw)).encode()
    else:
        body = damaged(whole, data)
    with tempfile.TemporaryDirectory() as folder:
        path = (
            Path(folder) / f"mill.usda.{suffix}"
            if suffix == "toml"
            else Path(folder) / f"mill.{suffix}"
        )
        path.write_bytes(body)
        if suffix == "toml":
            path = path.with_suffix("")
            path.write_bytes((models / "mill.usda").read_bytes())
        judge(lambda: unpack(body, str(path)) if suffix == "npz" else read_model(path))


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of one model in each form."""
    folder = tmp_path_factory.mktemp("models")
    header, chunk = lamp_tree_parts()
    (folder / "mill.glb").write_bytes(glb(header, chunk))
    inline = base64.b64encode(chunk).decode()
    header["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{inline}"
    (folder / "mill.gltf").write_text(json.dumps(header))
    (folder / "mill.npz").write_bytes(pack(read_model(mill(folder / "mill.usda"))))
    table = 'period = 4.0\n[parts."mill/rotor"]\naxis = [0, 0, 1]\nturns = 1\nlevel = 1\n'
    (folder / "mill.toml").write_text(table)
    return folder


@pytest.fixture(scope="module")
def frame(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """One small frame, as it is written."""
    from scenes.render.exr.header import frame_settings
    from scenes.render.frame_session import FrameSession

    small = ['render.size="8x8"', "render.spp=1", "view.detail=50"]
    path = tmp_path_factory.mktemp("frame") / "a.0001.exr"
    FrameSession(frame_settings(load_preset("zoo", small), "scalar_rgb")).render(1, path)
    return path.read_bytes()


@pytest.mark.slow
@fuzzed
@given(st.data())
def test_headers(frame: bytes, data: st.DataObject) -> None:
    """A frame with bytes of its header changed, or cut off."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.0001.exr"
        path.write_bytes(damaged(frame, data, 6000))
        judge(lambda: read_whole(path))


class Entry:
    """What a package might bring: anything, or an error of any kind."""

    name = "strange"
    value = "strange:thing"
    module = "strange"
    dist = None

    def __init__(self, found: Any) -> None:
        self.found = found

    def load(self) -> Any:
        if isinstance(self.found, type) and issubclass(self.found, BaseException):
            raise self.found("on purpose")
        return self.found


ERRORS = st.sampled_from([ValueError, ImportError, SystemExit, RecursionError, KeyError, OSError])
LIMITS = st.sampled_from(
    [
        lambda P, R, m: P / m,
        lambda P, R, m: None,
        lambda P, R, m: [1, 2],
        lambda P, R, m: P * float("nan"),
        lambda P, R, m: -P,
        lambda P: P,
        lambda P, R, m: 1 / 0,
    ]
)
METRICS = st.builds(
    Metric, name=TEXTS, about=TEXTS, limit=LIMITS, finite=st.booleans(), along_axis=st.booleans()
)


@fuzzed
@given(st.one_of(VALUES, ERRORS, METRICS))
def test_plug_ins(found: Any) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(entry_points, "installed", lambda group: {"strange": Entry(found)})
        patch.setattr(entry_points, "distribution", lambda entry: "strange 1.0")
        judge(lambda: entry_points.metric_by_name("strange"))


@pytest.mark.slow
@settings(fuzzed, max_examples=PROGRAMS)
@given(
    st.sampled_from(["count", "render", "show", "frames", "verify", "list", "run", "compare"]),
    st.lists(st.one_of(WORDS, st.tuples(FLAGS, WORDS)), max_size=4),
)
@example("verify", [("--json", "")])
@example("list", [])
@example("compare", ["0"])
@example("run", ["0"])
def test_whole_programs(name: str, words: list[str | tuple[str, str]]) -> None:
    """Each ends with 0, 1 or 2, and one line that says why; nothing is done for long."""
    flat = [each for word in words for each in ((word,) if isinstance(word, str) else word)]
    err = io.StringIO()
    before, judged = Path.cwd(), []

    def verdict(error: BaseException) -> tuple[int, str]:
        judged.append(error)
        return main_verdict(error)

    with (
        tempfile.TemporaryDirectory() as folder,
        contextlib.redirect_stderr(err),
        pytest.MonkeyPatch.context() as patch,
    ):
        patch.setattr(cli, "_verdict", verdict)
        os.chdir(folder)
        small = ["-D", 'render.size="4x4"', "-D", "terrain.reach=100"]
        preset = {"run": [], "compare": [], "verify": [], "list": []}.get(name, ["zoo", *small])
        out = ["-o", "out/a.####.exr"] if name in ("render", "frames") else []
        try:
            with pytest.raises(SystemExit) as left, contextlib.redirect_stdout(io.StringIO()):
                main([name, *preset, *out, *flat])
        finally:
            os.chdir(before)
    assert left.value.code in (0, 1, 2)
    note(f"exit {left.value.code}")
    assert "Traceback" not in err.getvalue() and "LODBENCH_TRACEBACK" not in err.getvalue()
    if left.value.code:
        last = err.getvalue().splitlines()[-1]
        assert last.startswith("lodbench: error: ")
        assert has_cure(judged[-1], last), f"no cure: {last}"


def has_cure(error: BaseException, line: str) -> bool:
    """Whether the line that a command ended with says what would do instead.

    One of the rules does, after the rule; the parser of words leads to the command's help; and
    what went wrong on the way says it after a semicolon.
    """
    if isinstance(error, InputError):
        rule, cure = " ".join(error.rule.split()), " ".join(error.cure.split())
        return bool(rule and cure) and line.endswith(f": {rule}; {cure}")
    if isinstance(error, click.UsageError):
        return re.search(r" \(see `lodbench( \w+)? --help`\)$", line) is not None
    return "; " in line
