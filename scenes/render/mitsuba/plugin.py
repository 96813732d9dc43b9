"""The renderer's plugins, made so that compiled code is the same every time."""

from typing import Any

import mitsuba as mi


def load_plugin(plan: dict[str, Any]) -> Any:
    """A plugin with its parts, made one after the other: at once, they are numbered by chance, and
    a JIT variant compiles their numbers."""
    return mi.load_dict(plan, parallel=False)
