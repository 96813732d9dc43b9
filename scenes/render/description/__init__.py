"""This package describes what is displayed as a scene of plain data, without the renderer."""
