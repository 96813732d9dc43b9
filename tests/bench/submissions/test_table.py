"""Each record of the public table is whole, of a pack of today, and its score follows from it."""

import json
import re
from pathlib import Path

import pytest

from bench.packs import make
from bench.packs.content import settings_of
from bench.submissions.entry import (
    BASELINE,
    SUBMISSIONS,
    pack_digest,
    read_submission,
    record_of,
    scored,
    setting_row,
)
from bench.submissions.score import Judged, plain
from lod.errors import InputError


def faults(folder: Path) -> list[str]:
    """What is wrong with the records of a folder, each with its file."""
    found = []
    records = {}
    for path in sorted(folder.glob("*.json")):
        try:
            records[path] = read_submission(path)
        except InputError as error:
            found.append(f"{path.name}: {error}")
    baselines = {r["pack"]: r for r in records.values() if r["program"].split()[:1] == [BASELINE]}
    for path, record in records.items():
        wrong = []
        if record["timing"] != "measured":
            wrong.append(f"seconds that are {record['timing']}, not measured")
        if not re.fullmatch("[0-9a-f]{40}", commit := record["machine"].get("commit", "")):
            wrong.append(f"sources of {commit}, which is no commit")
        if not wrong:
            settings_of(record["pack"])
            baseline = baselines.get(record["pack"])
            if baseline and baseline["pack_sha256"] != record["pack_sha256"]:
                wrong.append("another version of the pack than the baseline's")
            if path.stem != f"{record['program'].split()[0].lower()}-{record['pack']}":
                wrong.append("a file name that is not PROGRAM-PACK.json")
            score = scored(record["settings"], baseline)
            if (record["score"], record["told"]) != (plain(score.ratio), score.told):
                wrong.append(f"a score of {record['score']}, its measures give {score.ratio}")
        found += [f"{path.name}: {each}" for each in wrong]
    return found


def test_every_record_of_the_table_is_true():
    assert faults(SUBMISSIONS) == []


def submit(folder, pack, program, seconds, tampered=()):
    """Write the record of a program whose error falls with its time, as a runner does."""
    baseline = folder / f"blake-{pack.name}.json"
    rows = []
    for knob, flip in ((1, 0.02), (2, 0.03)):
        judged = Judged("", "", 0.0, flip, 0.01, 1.0, 1.0, ())
        run = {"repeat": 0, "seconds": seconds / knob, "cpu_seconds": 1.0}
        run |= {"peak_bytes": 10**9, "stages": {}}
        rows.append(setting_row(knob, {"still": judged}, [run], [pack / make.PACK]))
    beside = read_submission(baseline) if baseline.exists() else None
    made = record_of(pack, "me", program, "measured", rows, beside)
    made["machine"] |= {"commit": "0" * 40, "load": 0.1}
    name = f"{program.split()[0]}-{pack.name}.json"
    (folder / name).write_text(json.dumps(made | dict(tampered)))
    return made


NUMBERS = {"format": 1, "pack": "crowd-small", "references": {"still": {"spp": 64}}}


def write_pack(pack, numbers):
    (pack / make.PACK).write_text(json.dumps(numbers))
    (pack / make.RECIPE).write_text("{}")
    (pack / make.SUMS).write_text("".join(make._sums(pack)))


@pytest.fixture
def table(tmp_path):
    pack = tmp_path / "crowd-small"
    pack.mkdir()
    write_pack(pack, NUMBERS)
    (tmp_path / "table").mkdir()
    return tmp_path / "table", pack


def test_a_made_up_table_is_true_and_its_scores_are_those_of_the_times(table):
    folder, pack = table
    assert submit(folder, pack, "blake 1", 4.0)["score"] == 1
    assert submit(folder, pack, "mine 1", 6.0)["score"] == 1.5
    assert faults(folder) == []


@pytest.mark.parametrize(
    ("tampered", "fault"),
    [
        ({"score": 0.9}, "a score of 0.9, its measures give 1.5"),
        ({"pack_sha256": "0" * 64}, "another version of the pack"),
        ({"timing": "reported"}, "reported, not measured"),
        (
            {"machine": {"commit": "0" * 40 + "+changes", "cpu": "x", "cores": 2, "load": 0.1}},
            "+changes, which is no commit",
        ),
        ({"settings": []}, "at least 1 item"),
    ],
)
def test_a_tampered_record_is_found(table, tampered, fault):
    folder, pack = table
    submit(folder, pack, "blake 1", 4.0)
    submit(folder, pack, "mine 1", 6.0, tampered)
    assert any(fault in each for each in faults(folder)), faults(folder)


def test_seconds_that_were_changed_afterwards_are_found(table):
    folder, pack = table
    submit(folder, pack, "blake 1", 4.0)
    made = submit(folder, pack, "mine 1", 6.0)
    made["settings"][0]["runs"][0]["seconds"] = 3.0
    (folder / "mine-crowd-small.json").write_text(json.dumps(made))
    assert "its measures give 0.75" in faults(folder)[0]


def test_a_pack_is_the_same_whatever_noise_its_references_have(table):
    _, pack = table

    def digest(**changed):
        write_pack(pack, NUMBERS | changed)
        return pack_digest(pack)

    still = {"spp": 64, "noise": {"flip": 0.01}}
    assert digest() == digest(software="lodbench 9", references={"still": still, "walk": [1]})
    assert digest() != digest(references={"still": {"spp": 32}})
    assert digest(bounds=[1e-17, 0.12345678]) == digest(bounds=[-1e-17, 0.12345679])


@pytest.mark.parametrize("name", [make.PACK, make.RECIPE, make.SUMS])
@pytest.mark.parametrize("damage", ["missing", "cut", "a digit"])
def test_a_damaged_pack_is_refused(table, name, damage):
    _, pack = table
    text = (pack / name).read_text()
    if damage == "missing":
        (pack / name).unlink()
    else:
        changed = (
            text[: len(text) // 2]
            if damage == "cut"
            else text.translate(str.maketrans("163}", "270]"))
        )
        (pack / name).write_text(changed)
    with pytest.raises(InputError, match="finished pack"):
        make.read_pack(pack)
