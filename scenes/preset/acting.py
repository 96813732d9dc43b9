"""Does anything act in a preset?"""

from scenes.preset.tables import Preset


def has_acting(preset: Preset) -> bool:
    """Tell whether a preset has live actors, or a camera that acts."""
    return bool(preset.actors or preset.troupes or preset.script or preset.camera.behaviour)
