"""Judge videos by ColorVideoVDP, for another program. Run by a Python that has pycvvdp.

The argument is an archive of arrays: ``whole`` and the tested videos, (frames, h, w, 3), as they
are displayed, 0 to 1. The names of those and the rate are read as JSON from standard input; the
last line of standard output is JSON: the quality of each in JOD, and the display.
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
    metric = pycvvdp.cvvdp(display_name=DISPLAY, device=torch.device("cpu"), quiet=True)
    jod = {}
    for name in asked["videos"]:
        found, _ = metric.predict(
            arrays[name], arrays["whole"], dim_order="FHWC", frames_per_second=asked["fps"]
        )
        jod[name] = float(found)
    print(json.dumps({"jod": jod, "display": metric.get_info_string()}))


if __name__ == "__main__":
    main(sys.argv[1])
