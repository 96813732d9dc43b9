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
    text = (tmp_path / "g" / "README.md").read_text()
    assert "(zoo.png)" in text and "(zoo_level.png)" in text and "rabbits" in text
    assert "meadow" not in text


@pytest.mark.parametrize("name", gallery.FRAMES)
def test_frames_are_of_presets_that_exist(name):
    assert name in dict(gallery.preset_names())
