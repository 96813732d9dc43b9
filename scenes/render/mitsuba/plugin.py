"""The renderer's plugins, made so that compiled code is the same every time."""

from typing import Any

import mitsuba as mi


def load_plugin(plan: dict[str, Any]) -> Any:
    """Load a Mitsuba plugin, its parts one after the other.

    Loaded in parallel they are numbered by chance, and a JIT variant compiles their numbers.
    """
    return mi.load_dict(plan, parallel=False)
