"""Judge videos by ColorVideoVDP, for another program. Run by a Python that has pycvvdp.

The argument is an archive of arrays: ``whole`` and the tested videos, (frames, h, w, 3), as they
are displayed, 0 to 1. The names of those, the rate and the distances in pixels per degree are read
as JSON from standard input; the last line of standard output is JSON: the quality of each in JOD
from every distance, and the display.
"""

import json
import sys

import numpy as np
import pycvvdp
import torch

DISPLAY = "standard_4k"


def main(source: str) -> None:
    """Judge every video against the whole one."""
    asked = json.load(sys.stdin)
    arrays = np.load(source)
    height, width = arrays["whole"].shape[1:3]
    jod: dict[str, list[float]] = {name: [] for name in asked["videos"]}
    for ppd in asked["pixels_per_degree"]:
        seen = pycvvdp.vvdp_display_geometry((width, height), ppd=ppd)
        metric = pycvvdp.cvvdp(DISPLAY, None, seen, device=torch.device("cpu"), quiet=True)
        for name, judged in jod.items():
            found, _ = metric.predict(
                arrays[name], arrays["whole"], dim_order="FHWC", frames_per_second=asked["fps"]
            )
            judged.append(float(found))
    print(json.dumps({"jod": jod, "display": metric.get_info_string()}))


if __name__ == "__main__":
    main(sys.argv[1])
