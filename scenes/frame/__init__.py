"""This package makes the renderer's input of one frame from a world and a view."""
