"""Settings determine a frame, in whatever order a preset was written."""

from scenes.preset.load import load_preset
from scenes.render.files.manifest import settings_hash
from scenes.render.sequence.settings import frame_settings, preset_from_settings


def reversed_tables(table):
    return {
        name: reversed_tables(each) if isinstance(each, dict) else each
        for name, each in reversed(table.items())
    }


def test_settings_are_the_preset_again():
    preset = load_preset("zoo", ["render.variant=scalar_rgb"])
    found = preset_from_settings(frame_settings(preset, "scalar_rgb"))
    assert found.model_dump(exclude={"about"}) == preset.model_dump(exclude={"about"})


def test_settings_of_one_hash_number_their_species_alike():
    # Ids of objects count species by species: one hash must not stand for two frames.
    settings = frame_settings(load_preset("zoo"), "scalar_rgb")
    other = reversed_tables(settings)
    assert settings_hash(other) == settings_hash(settings)
    orders = [list(preset_from_settings(each).species) for each in (settings, other)]
    assert orders[0] == orders[1] == sorted(orders[0])
