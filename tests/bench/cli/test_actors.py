"""`lodbench ask`, `act` and `render --say`: actors by the command line, and frames in any order."""

import json
from pathlib import Path

import pytest

from bench.cli.main import main
from scenes.actors.acting import Acting
from scenes.actors.performance import ActedFrame
from scenes.presets.load import load_preset
from scenes.render.exr.frames_on_disk import read_whole
from scenes.render.object_keys import identities
from scenes.scene import Scene

TINY = """
[terrain]
reach = 100
amplitude = 0
[acting]
frames = 4
[[script]]
to = "joe right arm"
do = "orient y -40deg"
[actors.joe]
model = "figure"
position = [1, 4]
[actors.ann]
model = "figure"
position = [3, 4]
[actors.bun]
model = "rabbit"
position = [0, 3]
heading = 90
behaviour = "herd"
[render]
size = "16x9"
spp = 1
variant = "scalar_rgb"
"""
FOOT = "joe right leg/lower leg/foot"


@pytest.fixture(autouse=True)
def preset(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.toml").write_text(TINY)


def run(*words: str) -> int:
    with pytest.raises(SystemExit) as left:
        main(words)
    return int(left.value.code or 0)


def test_what_is_said_is_answered(capfd: pytest.CaptureFixture[str]) -> None:
    """Figure 4: the foot's orientation is replaced by the same, turned by 40° about y."""
    answers = []
    for said in ((), ("--say", f"{FOOT} orient y 40deg")):
        assert run("ask", "tiny.toml", f"{FOOT} orientation", "--json", *said) == 0
        answers.append(json.loads(capfd.readouterr().out)["answer"])
    turned = sum(a * b for a, b in zip(*answers, strict=True))
    assert turned == pytest.approx(0.9396926, abs=1e-6)  # cos 20°


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("ask", "tiny.toml", "joe right arm/hnd where"), "nearest known route is 'torso/abdomen"),
        (("ask", "tiny.toml", "jo heading"), "the nearest known route is 'joe'"),
        # Parts are a whole's hidden state: they are not handed out, nor reached but through it.
        # The whole's protocol is not that of its parts, and theirs not its.
        (("ask", "tiny.toml", f"{FOOT} heading"), "/foot': refuses: understands no question"),
        (("act", "tiny.toml", "-o", "o", "--say", f"{FOOT} go 1"), "understands no change 'go'"),
        # A whole is assembled from parts of known types.
        (("render", "tiny.toml", "-o", "o/a.####.exr", "--frames", "5"), "acting.frames=5"),
        (("act", "meadow", "-o", "o"), "a preset in which somebody acts"),
    ],
)
def test_a_refusal_is_one_line(
    words: tuple[str, ...], says: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run(*words) == 2
    out, err = capfd.readouterr()
    assert says in err
    assert err.count("\n") == 1
    assert not out


def test_objects_have_the_names_of_actors() -> None:
    chosen = load_preset("tiny.toml", ["view.detail=0.1"])
    names = [each.of for each in identities(Scene(chosen), 2)]
    assert names.count("joe") == names.count("bun") == 1


def test_frames_replay_from_the_track_in_any_order(
    capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    hashes: list[dict[int, str]] = []
    for folder, frames in (("a", ("1,3",)), ("b", ("3", "1"))):
        found = {}
        for asked in frames:
            assert (
                run(
                    "render", "tiny.toml", "-o", f"{folder}/f.####.exr", "--json", "--frames", asked
                )
                == 0
            )
            *records, _ = map(json.loads, capfd.readouterr().out.splitlines())
            found |= {each["frame"]: each["sha256"] for each in records}
        hashes.append(found)
    assert hashes[0] == hashes[1]
    assert hashes[0][1] != hashes[0][3]
    (track,) = (tmp_path / "a").glob("actors-*.npz")
    assert track.read_bytes() == (tmp_path / "b" / track.name).read_bytes()
    assert len(read_whole(tmp_path / "a" / "f.0001.exr").settings["track"]) == 64
    track.unlink()  # verify acts again, and finds the frames as they were
    (tmp_path / "a" / "f.0003.exr").write_bytes(b"")
    assert run("verify", "a", "--repair") == 0
    assert run("verify", "a") == 0


def test_a_pass_that_was_interrupted_is_acted_again_to_the_same_bytes(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assert run("act", "tiny.toml", "-o", "whole") == 0
    real, acted = Acting.act, []

    def interrupted(self: Acting) -> ActedFrame:
        acted.append(1)
        if len(acted) == 3:
            raise KeyboardInterrupt
        return real(self)

    with monkeypatch.context() as patch:
        patch.setattr(Acting, "act", interrupted)
        assert run("act", "tiny.toml", "-o", "cut") == 130
    assert not list((tmp_path / "cut").iterdir())
    assert run("act", "tiny.toml", "-o", "cut") == 0
    (track,) = (tmp_path / "whole").glob("*.npz")
    assert (tmp_path / "cut" / track.name).read_bytes() == track.read_bytes()


@pytest.mark.slow
def test_any_number_of_workers_renders_the_same_frames(
    capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    hashes = []
    for folder, how in (("alone", ()), ("cluster", ("--cluster", "2"))):
        words = ("render", "tiny.toml", "-o", f"{folder}/f.####.exr", "--json", "--frames", "1-4")
        assert run(*words, *how) == 0
        *records, _ = map(json.loads, capfd.readouterr().out.splitlines())
        hashes.append({each["frame"]: each["sha256"] for each in records})
    assert len(hashes[0]) == 4
    assert hashes[0] == hashes[1]
    first, second = (next((tmp_path / each).glob("*.npz")) for each in ("alone", "cluster"))
    assert first.read_bytes() == second.read_bytes()
