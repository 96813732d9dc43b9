"""The gallery's page: only what has its pictures, and both of them."""

import pytest
from click.testing import CliRunner
from PIL import Image

from bench.studies import gallery


def test_a_page_of_what_was_rendered(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(gallery, "render_preset", lambda name, *how: asked.append(name) or tmp_path)

    def save_pictures(frame, name, folder):
        for each in (name, f"{name}_level"):
            Image.new("RGB", (4, 4)).save(folder / f"{each}.png")

    monkeypatch.setattr(gallery, "save_pictures", save_pictures)
    said = CliRunner().invoke(gallery.command, ["zoo", "-o", str(tmp_path / "g")])
    assert said.exit_code == 0, said.output
    assert asked == ["zoo"]
    page = tmp_path / "g" / "README.md"
    assert "_sheet.png" not in page.read_text() and "Figure 4" not in page.read_text()
    for name in ("playground_sheet", "playground_level", "figure_4"):
        Image.new("RGB", (4, 4)).save(tmp_path / "g" / f"{name}.png")
    assert CliRunner().invoke(gallery.command, ["-o", str(tmp_path / "g"), "none"]).exit_code == 0
    text = page.read_text()
    assert "--frames 1-96 --preview" in text and "(playground_sheet.png)" in text
    assert f"--say '{gallery.FIGURE_4}'" in text
    assert "(zoo.png)" in text and "(zoo_level.png)" in text and "rabbits" in text
    assert "meadow" not in text


@pytest.mark.parametrize("name", gallery.FRAMES)
def test_frames_are_of_presets_that_exist(name):
    assert name in dict(gallery.preset_names())


@pytest.mark.slow
def test_a_reference_is_shown_where_it_was_asked_for(tmp_path, monkeypatch):
    """It is the middle of both pictures, in the exposure of the one as shipped."""
    monkeypatch.setattr(gallery, "BESIDE", {"crowd": "24x16"})
    monkeypatch.setattr(gallery, "SHOWN_PX", 8)
    monkeypatch.setattr(gallery, "BESIDE_SPP", 1)
    target = tmp_path / "crowd_beside.png"
    gallery.render_beside("crowd", tmp_path, target)
    with Image.open(target) as sheet:
        assert 16 < sheet.width < 2 * 24 and sheet.height > 16
    page = gallery.gallery_page([("crowd", "many"), ("zoo", "few")], tmp_path)
    assert page.count("_beside.png") == 1 and "At 24x16, 1 samples" in page
