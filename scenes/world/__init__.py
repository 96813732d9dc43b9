"""From a preset to a world and a view."""
