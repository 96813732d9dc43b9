"""How different does a moving sequence look from the whole one? ColorVideoVDP, in its environment.

Mantiuk et al., "ColorVideoVDP: A visual difference predictor for image, video and display
distortions", ACM Trans. Graph. 43(4), 2024. Ten JOD are no difference; one fewer is a difference
that three of four people would choose. The display is its ``standard_4k``: a 30-inch 4K monitor of
200 cd/m², seen from two of its heights, 75.4 pixels a degree, or from as far as is asked.
"""

import json
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.methods.environments import VIDEO, answer_of


def just_objectionable_differences(
    tested: Mapping[str, np.ndarray],
    whole: np.ndarray,
    fps: float,
    pixels_per_degree: Sequence[float] = (75.4,),
) -> dict[str, list[float]]:
    """Return the quality of every displayed sequence, (n, h, w, 3) each, in JOD, by name.

    Each has one from every distance, which is told in pixels per degree.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "videos.npz"
        arrays: dict[str, Any] = {"whole": whole, **tested}
        np.savez(path, **arrays)
        about = {"fps": fps, "pixels_per_degree": list(pixels_per_degree)}
        asked = json.dumps({"videos": list(tested), **about})
        found = answer_of(VIDEO, "video_child.py", asked, str(path))
    return {name: list(map(float, values)) for name, values in found["jod"].items()}
