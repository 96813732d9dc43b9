"""What there is to see, and how it becomes pixels: objects, the endless field, presets, rendering.

Only ``scenes.render`` knows a renderer.
"""
