"""What a scene description is: plain data that any renderer could read."""

from typing import Any

Description = dict[str, Any]
"""Nested dicts of numbers, text and arrays (see ``describe_frame``)."""

MEDIUM = "medium"
"""What the box of air is called, where the air is part of the scene."""
