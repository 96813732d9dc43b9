"""No command replaces what it did not write, unless it is told to."""

import shutil
from pathlib import Path

import pytest
from PIL import Image

from bench.cli.main import main
from bench.report import write
from lod.errors import InputError
from scenes.render.pictures import save_picture

TINY = Path(__file__).with_name("tiny.toml")


@pytest.fixture
def lodbench(capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(TINY, ".")

    def run(*words: str) -> tuple[int, str]:
        with pytest.raises(SystemExit) as left:
            main(words)
        return left.value.code, capfd.readouterr().err

    return run


def test_usd_replaces_nothing_unasked(lodbench):
    pytest.importorskip("pxr")
    Path("thesis.usda").write_text("years of work")
    code, err = lodbench("usd", "tiny.toml", "-o", "thesis.usda")
    assert (code, err.count("\n")) == (2, 1)
    assert "not there yet; choose another name, or --overwrite" in err
    assert Path("thesis.usda").read_text() == "years of work"
    assert lodbench("usd", "tiny.toml", "-o", "thesis.usda", "--overwrite") == (0, "")
    assert Path("thesis.usda").read_text().startswith("#usda")
    assert lodbench("usd", "tiny.toml", "-o", "other.usda") == (0, "")
    assert not list(Path().glob(".*"))


@pytest.mark.parametrize("name", ["a.png", "a.mp4"])
def test_previews_replace_previews_alone(lodbench, name):
    Path("out").mkdir()
    Path("out", name).write_text("a photograph")
    words = "render", "tiny.toml", "-o", "out/a.####.exr", "--preview"
    code, err = lodbench(*words)
    assert (code, err.count("\n")) == (2, 1)
    assert f"--preview: 'out/{name}': a file that is not there yet" in err
    assert sorted(path.name for path in Path("out").iterdir()) == [name]
    Path("out", name).unlink()
    save_picture(Image.new("RGB", (2, 2)), "out/a.png")
    assert lodbench(*words) == (0, "")
    assert Image.open("out/a.png").size == (16, 9)


def test_a_report_replaces_reports_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(write, "read_records", lambda folder: ("a record",))
    monkeypatch.setattr(write, "_place", lambda record: 0)
    monkeypatch.setattr(write, "_sections", lambda *_: [])
    monkeypatch.setattr(write, "to_html", lambda report: "<html>lodbench</html>")
    monkeypatch.setattr(write, "to_markdown", lambda report: "# lodbench")
    (tmp_path / "claims.csv").write_text("my claims")
    with pytest.raises(InputError, match=r"claims\.csv.*--overwrite"):
        write.write_report(tmp_path)
    assert (tmp_path / "claims.csv").read_text() == "my claims"
    assert not (tmp_path / "report.html").exists()
    write.write_report(tmp_path, overwrite=True)
    write.write_report(tmp_path)
    assert (tmp_path / "claims.csv").read_text() != "my claims"
