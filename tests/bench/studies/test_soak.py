"""A soak is drawn from its seed, finds what is planted, and finds nothing in the program."""

import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from bench.studies.soak import damage, judge
from bench.studies.soak.judge import Broken, judge_run, judge_verdict
from bench.studies.soak.ledger import Ledger
from bench.studies.soak.looks import FRAMES, LOOKS, Truth, frame_name
from bench.studies.soak.plan import SIGNALS, STREAMS, Burst, Command, Harm, Hit, Moment, plan_round
from bench.studies.soak.program import Run
from bench.studies.soak.study import command
from scenes.render.variants import JIT_VARIANT, SCALAR_VARIANT, works

PLANS = [plan_round(1, number) for number in range(400)]


def commands() -> Iterator[Command]:
    for plan in PLANS:
        for step in plan.steps:
            if isinstance(step, Burst):
                yield from step.commands


def done(*names: str) -> str:
    lines = [json.dumps({"path": f"out/{name}", "sha256": "0" * 64}) for name in names]
    return "".join(f"{line}\n" for line in lines)


def ended(verb: str = "render", code: int | None = 0, out: str = "", err: str = "", **more) -> Run:
    signals, left = more.pop("signals", ()), more.pop("left", ())
    return Run(Command(verb, **more), code, out, err, signals, 0, left)


def kinds(broken: list[Broken]) -> list[str]:
    return [each.kind for each in broken]


def test_a_round_is_drawn_from_seed_and_number_alone() -> None:
    assert PLANS[7] == plan_round(1, 7) != plan_round(2, 7)
    assert len(set(map(str, PLANS))) == len(PLANS)


def test_four_hundred_rounds_hold_everything_that_is_promised() -> None:
    drawn = list(commands())
    hits = [each.hit for each in drawn if each.hit]
    harms = {step.kind for plan in PLANS for step in plan.steps if isinstance(step, Harm)}
    assert {each.verb for each in drawn} == {"render", "long", "verify", "repair", "ids", "count"}
    assert {each.look for each in drawn} == set(LOOKS)
    assert {each.stream for each in drawn} == set(STREAMS)
    assert {each.signal for each in hits} == set(SIGNALS)
    assert {each.target for each in hits} == {"program", "group", "worker"}
    assert any("--cluster" in each.flags and each.hit for each in drawn)
    assert harms == {*damage.FRAME_DAMAGES, *damage.MANIFEST_DAMAGES, *damage.PLANTS}
    bursts = [step for plan in PLANS for step in plan.steps if isinstance(step, Burst)]
    assert {len(each.commands) for each in bursts} == {1, 2, 3, 4}
    rivals = [burst for burst in bursts if len({each.look for each in burst.commands}) > 1]
    assert sum(not any(each.hit for each in burst.commands) for burst in rivals) > 50
    assert any(each.freeze for each in bursts) and any(each.meanwhile for each in bursts)
    assert 0.15 < sum(plan.disk_kb is not None for plan in PLANS) / len(PLANS) < 0.35
    assert all(each.hit.moment.cpu_s <= 0.4 for each in drawn if each.verb == "long" and each.hit)
    endless = [each.hit for each in drawn if each.verb == "long"]
    assert all(hit and hit.moment.frames == 0 for hit in endless)  # it would take for ever


def test_what_is_written_of_a_command_is_what_is_not_usual() -> None:
    hit = Hit("TERM", "group", Moment(0.5, 0, 0.0), 0.25, False)
    assert str(Command("verify")) == "Command(verb=verify)"
    assert "hit=Hit(signal=TERM, target=group, moment=Moment(cpu_s=0.500" in str(
        Command("render", hit=hit)
    )


@pytest.mark.parametrize(
    "run, kind",
    [
        (ended(code=1, err="Traceback (most recent call last):\nlodbench: x"), judge.TRACEBACK),
        (ended(code=1, err=""), judge.SILENT),
        (ended(code=-15, signals=("TERM",)), judge.CODE),
        (ended(code=130), judge.CODE),
        (ended(code=None, signals=("INT",)), judge.HANGS),
        (ended(left=("python worker",)), judge.PROCESSES),
        (ended(out="{}\nhello\n"), judge.NOT_JSON),
    ],
)
def test_each_bad_end_is_found(run: Run, kind: str) -> None:
    assert kinds(judge_run(run)) == [kind]


@pytest.mark.parametrize(
    "run",
    [
        ended(code=143, signals=("TERM",)),
        ended(code=0, signals=("HUP",)),
        ended(code=-9, out='{"frame": 1', signals=("KILL",)),
        ended(code=2, err="lodbench: error: no"),
        Run(Command("render", stream="no stderr"), 1, "", None, (), 0, ()),
    ],
)
def test_a_good_end_is_none_of_them(run: Run) -> None:
    assert judge_run(run) == []


def verdict(*wrong: str, code: int = 0) -> Run:
    lines = [{"path": f"out/{name}", "wrong": ["why"]} for name in wrong]
    out = "".join(json.dumps(line) + "\n" for line in [*lines, {"frames": 3, "wrong": len(wrong)}])
    return ended("verify", code=code, out=out, err="lodbench: x" if code else "")


def test_verdicts_are_held_against_the_bytes() -> None:
    looks = {"a.0001.exr": "plain", "a.0002.exr": None, "a.0003.exr": "seed"}
    right = {"a.0001.exr", "a.0003.exr"}
    assert judge_verdict(verdict("a.0002.exr", code=1), looks, right, False) == []
    assert kinds(judge_verdict(verdict(), looks, right, False)) == [judge.PASSED]
    both = verdict("a.0002.exr", "a.0003.exr", code=1)
    assert kinds(judge_verdict(both, looks, right, False)) == [judge.REFUSED]
    assert judge_verdict(both, looks, right, True) == []
    (no_verdict,) = judge_verdict(ended("verify", 2, err="lodbench: no"), looks, right, False)
    assert (no_verdict.kind, no_verdict.times) == (judge.REFUSED, 2)
    assert kinds(judge_verdict(verdict(code=1), {}, set(), False)) == [judge.REFUSED]


def test_promised_frames_are_missed_replaced_or_there() -> None:
    names = [frame_name("a", frame) for frame in FRAMES]
    whole = dict.fromkeys(names, "plain")
    ledger = Ledger()
    assert ledger.settle([ended()], whole) == []  # exit 0 promises all of them
    (lost,) = ledger.settle([], dict.fromkeys(names[2:], "plain"))
    assert (lost.kind, lost.times) == (judge.LOST, 2)
    assert ledger.settle([], dict.fromkeys(names[2:], "plain")) == []  # and is counted once
    other = ended(look="seed", code=1, out=done(names[5]), err="lodbench: x")
    replaced = {**whole, names[5]: "seed"}
    assert [each.times for each in ledger.settle([other], replaced)] == [1]
    anew = ended(look="seed", flags=("--overwrite",))
    assert ledger.settle([anew], dict.fromkeys(names, "seed")) == []
    assert kinds(ledger.settle([ended(look="seed")], whole)) == [judge.LOST]


def test_two_owners_of_one_frame_are_one_too_many() -> None:
    names = [frame_name("a", frame) for frame in FRAMES]
    both = [ended(), ended(look="seed")]
    (lost,) = Ledger().settle(both, dict.fromkeys(names, "seed"))
    assert (lost.kind, lost.times) == (judge.LOST, len(FRAMES))
    again = [ended(), ended(flags=("--threads", "2"))]  # the same frames, so nobody minds
    assert Ledger().settle(again, dict.fromkeys(names, "plain")) == []


def test_what_was_to_be_replaced_may_be_the_old_one_or_the_new_one() -> None:
    names = [frame_name("a", frame) for frame in FRAMES]
    ledger, whole = Ledger(), dict.fromkeys(names, "plain")
    refused = ended(look="seed", code=2, err="lodbench: x", flags=("--overwrite",))
    assert ledger.settle([ended(), refused], whole) == []
    ledger.note_repair()
    assert ledger.settle([ended()], whole) == []
    (lost,) = ledger.settle([], {**whole, names[3]: None})
    assert (lost.kind, lost.times) == (judge.LOST, 1)


def test_damage_releases_from_the_promise() -> None:
    names = [frame_name("a", frame) for frame in FRAMES]
    ledger, whole = Ledger(), dict.fromkeys(names, "plain")
    assert ledger.settle([ended()], whole) == []
    ledger.note_harm([names[0], "manifest.json"])
    assert ledger.manifest_harmed and ledger.harmed == {names[0], "manifest.json"}
    assert ledger.settle([], {**whole, names[0]: None}) == []
    ledger.note_repair()
    assert not ledger.manifest_harmed and not ledger.harmed


@pytest.mark.parametrize("kind", [*damage.FRAME_DAMAGES, *damage.MANIFEST_DAMAGES, *damage.PLANTS])
def test_each_damage_changes_what_it_says(kind: str, tmp_path: Path) -> None:
    frames = {
        frame_name("a", k): {"sha256": str(k), "state": "done", "settings": "x"} for k in (1, 2)
    }
    settings = {"x": {"render": {"spp": 1}}, "y": {"render": {"spp": 2}}}
    manifest = {"version": 2, "settings": settings, "frames": frames}
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    for frame in (1, 2):
        (tmp_path / frame_name("a", frame)).write_bytes(bytes([frame]) * 64)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    named = damage.do_damage(tmp_path, kind, 0.0, 0.5)
    after = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert named == {name for name in {*before, *after} if before.get(name) != after.get(name)}
    assert named and all(name == "manifest.json" for name in named) == kind.startswith("manifest")


def test_bytes_tell_whose_frame_it_is() -> None:
    truth = Truth({"plain": {1: "a", 2: "b"}, "seed": {1: "c", 2: "d"}})
    assert [truth.look_of(1, "c"), truth.look_of(2, "d"), truth.look_of(2, "a")] == [
        "seed",
        "seed",
        None,
    ]


@pytest.mark.slow
@pytest.mark.parametrize("variant, minutes", [(SCALAR_VARIANT, 3), (JIT_VARIANT, 1)])
def test_a_short_soak_breaks_nothing(variant: str, minutes: int, tmp_path: Path) -> None:
    if (why := works(variant)) is not True:
        pytest.skip(f"{variant} does not work here: {why}")
    words = ["--minutes", str(minutes), "--seed", "29", "--variant", variant, "--json"]
    said = CliRunner().invoke(command, [*words, "-o", str(tmp_path)])
    found = json.loads(said.stdout.splitlines()[0])
    assert not Counter(found["broken"]).total(), found["how"]
    assert found["tried"]["rounds"] and found["tried"]["frames judged by verify"] > 10
    assert said.exit_code == 0 and not any(tmp_path.iterdir())
