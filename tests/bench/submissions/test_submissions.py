"""The score reads time at an error, an executable is timed from outside, submissions are listed."""

import json
import math
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.statistics.steps import LEAST_BESIDE, find_step
from bench.submissions.diagnosis import best_cause, moved, registration
from bench.submissions.entry import check_again, views_of
from bench.submissions.executable import NAMES, execute, without_references, words_of
from bench.submissions.score import Target, Timed, judge_picture, score
from bench.submissions.site import HEADS, as_csv, as_html, table_rows, write_site
from lod.errors import InputError
from scenes.frame.layers import SKY_Z
from scenes.render.pictures import auto_exposure
from tests.bench.submissions.test_table import NUMBERS, write_pack

SIZE = 48, 80


@pytest.fixture(scope="module")
def target():
    """A smooth land below a sky, with independent noise in both halves."""
    rng = np.random.default_rng(1)
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    land = y > 20
    light = np.where(land, 0.2 + 0.1 * np.sin(x / 3) * np.sin(y / 2) + 0.002 * x, 0.8)
    right = light[..., None] * np.array([0.9, 1.0, 0.7])
    halves = tuple(right * (1 + 0.02 * rng.standard_normal(right.shape)) for _ in range(2))
    shares = np.stack([land.astype(float), 1.0 - land])
    Z = np.where(land, 30.0, float(SKY_Z))
    return Target(halves, Z, shares, (0.0, float(SKY_Z)), {})


def handed(target, seed=2):
    rng = np.random.default_rng(seed)
    return target.mean + 0.02 * target.mean * rng.standard_normal(target.mean.shape)


# Validity.


def test_a_picture_with_noise_of_its_own_counts(target):
    found = judge_picture(handed(target), target, target.Z)
    assert (found.void, found.cause) == ("", "")
    assert found.land == pytest.approx(1, abs=0.002)
    assert found.coverage == pytest.approx(1)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda p: p[:, :-1], "size: 79x48, must be 80x48"),
        (lambda p: np.where(np.arange(80)[None, :, None] == 3, np.inf, p), "48 pixels"),
        (lambda p: 0 * p, "no light"),
        (lambda p: 1.1 * p, "light: the sky is 1.100"),
        (lambda p: moved(p, 1.02, 0, 0), "camera"),
    ],
)
def test_what_is_wrong_is_void_with_its_reason(target, change, why):
    assert why in judge_picture(change(handed(target)), target).void


def test_every_repetition_of_the_references_noise_is_found(target):
    for picture in (target.mean, *target.halves):
        assert "a copy" in judge_picture(picture, target).void
    assert "a copy" not in judge_picture(handed(target), target).void


@given(scale=st.floats(0.97, 1.03), dx=st.floats(-2, 2), dy=st.floats(-2, 2))
def test_registration_finds_what_was_moved(scale, dx, dy):
    y, x = np.mgrid[:60, :90]
    picture = np.sin(x / 5) + np.cos(y / 4) + np.sin((x + y) / 9)
    found = registration(moved(picture, scale, dx, dy), picture)
    assert found == pytest.approx((scale, dx, dy), abs=0.02)


def test_half_of_a_packs_mistake_is_named_with_how_much(target):
    y, _ = np.mgrid[: SIZE[0], : SIZE[1]]
    wrong = target.mean * (1 + 0.3 * (y > 30))[..., None]
    tested = target.mean * (1 + 0.15 * (y > 30))[..., None]
    exposure = auto_exposure(target.mean)
    found = best_cause(tested, target.mean, exposure, {"sun elsewhere": wrong}, target.Z)
    assert found.name.startswith("sun elsewhere, 0.5")
    assert found.explains > 0.9


# The score.


@given(slope=st.floats(0.3, 3), flip=st.floats(0.011, 0.039))
def test_time_is_read_along_the_straight_line_of_logarithms(slope, flip):
    runs = [Timed(error, True, error**-slope) for error in (0.01, 0.02, 0.04)]
    found = score(runs, flip, 2.0)
    assert found.ratio == pytest.approx(flip**-slope / 2)


def test_what_is_void_or_too_far_off_has_no_score():
    runs = [Timed(0.01, False, 1.0), Timed(0.05, True, 1.0)]
    assert math.isnan(score(runs, 0.02, 1.0).ratio)
    assert score(runs[:1], 0.02, 1.0).told == "void"
    assert score([Timed(0.01, True, math.nan)], 0.02, 1.0).told == "no seconds"
    bound = score([Timed(0.01, True, 3.0)], 0.02, 1.0)
    assert bound.ratio == 3
    assert bound.told.startswith("at most")


# A program that is called.


def test_seconds_memory_and_stages_are_measured_from_outside(tmp_path):
    grandchild = "b = bytearray(150_000_000); import time; time.sleep(0.5)"
    child = (
        "import subprocess, sys, time; t = time.process_time()\n"
        "while time.process_time() - t < 0.3: pass\n"
        f"subprocess.run([sys.executable, '-c', {grandchild!r}])\n"
        'print(\'{"stages": {"build": 0.25}}\')'
    )
    found = execute([sys.executable, "-c", child], tmp_path / "log.txt")
    assert found.seconds > 0.8
    assert 0.3 < found.cpu_seconds < found.seconds + 0.5
    assert 150e6 < found.peak_bytes < 400e6
    assert found.stages == {"build": 0.25}


def test_a_program_that_fails_or_hangs_is_ended_and_said(tmp_path):
    with pytest.raises(InputError, match="exit code 3"):
        execute([sys.executable, "-c", "print('no sky'); exit(3)"], tmp_path / "log.txt")
    with pytest.raises(InputError, match="took too long"):
        execute([sys.executable, "-c", "while True: pass"], tmp_path / "log.txt", timeout_s=0.5)


@pytest.mark.parametrize(
    ("command", "why"),
    [
        ("true {scene}", "writes the picture"),
        ("true {exr} {sun}", "names are"),
        ("no-such-program {exr}", "a program that is here"),
        ("true '{exr}", "a command"),
    ],
)
def test_commands_that_cannot_run_are_refused(command, why):
    with pytest.raises(InputError, match=why):
        words_of(command, dict.fromkeys(NAMES, "x"))


def test_a_value_with_blanks_stays_one_word():
    values = dict.fromkeys(NAMES, "x") | {"scene": "a b; rm"}
    assert words_of("true {scene} -o {exr}", values) == ["true", "a b; rm", "-o", "x"]


def test_a_program_sees_no_reference(tmp_path):
    pack = tmp_path / "pack"
    (pack / "reference").mkdir(parents=True)
    (pack / "reference" / "still.exr").write_bytes(b"secret")
    numbers = {"camera": {"fov_deg": 60, "still": {"size": [4, 3]}, "walk": {}}, "references": 1}
    (pack / "pack.json").write_text(json.dumps(numbers))
    with without_references(pack) as scene:
        assert not list(scene.rglob("*.exr"))
        assert "references" not in json.loads((scene / "pack.json").read_text())
        camera = json.loads((scene / "camera.json").read_text())
        assert camera == {"fov_deg": 60, "size": [4, 3]}
    assert json.loads((pack / "pack.json").read_text()) == numbers
    assert [each.name for each in tmp_path.iterdir()] == ["pack"]


def test_views_are_told_by_their_names(tmp_path):
    found = views_of([tmp_path / "mine.exr", tmp_path / "walk.0003.exr"])
    assert set(found) == {"still", "0003"}
    with pytest.raises(InputError, match="one picture of a view"):
        views_of([tmp_path / "a.exr", tmp_path / "b.exr"])


# The table.


def record(score=1.0, date="2026-01-01", program="mine 1", void=""):
    still = {"void": void, "flip": 0.02, "land": 1.0, "coverage": None}
    run = {"seconds": 2.0, "peak_bytes": 10**9}
    return {
        "format": 1,
        "pack": "crowd-small",
        "pack_sha256": "0",
        "who": "<me>",
        "date": date,
        "program": program,
        "timing": "measured",
        "score": score,
        "told": "",
        "machine": {"cpu": "x", "cores": 2},
        "settings": [{"setting": 1, "runs": [run], "pictures": {"still": still}, "sha256": {}}],
    }


def test_rows_are_by_score_and_nothing_of_a_record_is_markup():
    rows = table_rows([record(2.0), record(0.5, program="other 1"), record(None, void="no sky")])
    assert [row[HEADS.index("score")] for row in rows] == ["0.5", "2", ""]
    assert "void: no sky" in rows[-1]
    assert "<me>" not in as_html(rows)
    assert "<me>" in as_csv(rows)


HOSTILE = {
    "its settings are none": {"settings": []},
    "a picture lacks what is shown": {
        "settings": [{**record()["settings"][0], "pictures": {"still": {}}}]
    },
    "its score is not finite": {"score": float("inf")},
}


@pytest.mark.parametrize("case", HOSTILE)
def test_a_record_that_cannot_be_is_one_line(tmp_path, case):
    (tmp_path / "bad.json").write_text(json.dumps(record() | HOSTILE[case]))
    with pytest.raises(InputError, match="`lodbench score` wrote") as refused:
        write_site(tmp_path, tmp_path / "site")
    assert str(refused.value).count("\n") == 0


def test_a_spreadsheet_calculates_nothing_of_a_record():
    text = as_csv(table_rows([record(program="=1+1"), record(program="-2 @x")]))
    assert ",'=1+1," in text and ",'-2 @x," in text


def test_a_step_in_the_history_is_told_with_its_date(tmp_path):
    scores = [1.0, 1.01, 0.99, 1.0, 1.02, 1.3, 1.31, 1.29, 1.32, 1.3]
    for k, each in enumerate(scores):
        made = record(each, f"2026-01-{k + 1:02d}")
        (tmp_path / f"{k}.json").write_text(json.dumps(made))
    page, table = write_site(tmp_path, tmp_path / "site")
    assert "times 1.299 from 2026-01-06 on" in page.read_text()
    assert table.read_text().count("\n") == 11
    (tmp_path / "bad.json").write_text("{}")
    with pytest.raises(InputError, match=r"bad\.json"):
        write_site(tmp_path, tmp_path / "site")


@given(st.lists(st.floats(-1, 1), max_size=2 * LEAST_BESIDE - 1))
def test_few_values_have_no_step(values):
    assert find_step(np.array(values, float)) is None


def test_steps_of_chance_are_as_rare_as_the_level_says():
    rng = np.random.default_rng(3)
    found = [find_step(rng.standard_normal(12)) for _ in range(300)]
    assert sum(each is not None for each in found) <= 10  # 3 are expected
    stepped = [find_step(rng.standard_normal(20) + 3 * (np.arange(20) >= 8)) for _ in range(20)]
    assert sum(each is not None and abs(each.row - 8) <= 1 for each in stepped) >= 18


def test_a_record_of_another_pack_is_refused(tmp_path):
    write_pack(tmp_path, NUMBERS)
    with pytest.raises(InputError, match="a record of"):
        check_again(record(), [], tmp_path)
