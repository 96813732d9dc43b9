"""This package has scenes and makes pixels of it: field, presets, rendering.

Only ``scenes.render`` imports a renderer.
"""
