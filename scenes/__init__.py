"""This package has what there is to see and makes pixels of it: field, presets, rendering.

Only ``scenes.render`` imports a renderer.
"""
