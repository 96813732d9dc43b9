"""The method of prune.c as a program of `lodbench run methods`: it prunes, and lodbench draws.

    cc -O2 -std=c99 -o prune prune.c -lm
    python prune_runner.py ./prune PACK PACK/camera.json -o OUT.exr --knob 4 --seed 0

The knob is how many pixels a part must cover to be kept. PACK is a pack with its recipe, and not
the copy without references that other runners get, because lodbench makes its world anew.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SAMPLES = 20  # a quarter more than the baseline has, whose error is else just not reached


def main():
    """Prune in C, draw what is kept, print the seconds of each stage."""
    parser = argparse.ArgumentParser()
    for name in ("prune", "pack", "camera"):
        parser.add_argument(name)
    parser.add_argument("-o", required=True)
    parser.add_argument("--knob", type=float, default=4)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    camera = json.loads(Path(asked.camera).read_text())
    pixel = 2 * math.tan(math.radians(camera["fov_deg"]) / 2) / camera["size"][0]
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        kept = f"{folder}/kept.bin"
        where = [*camera["eye"], pixel, asked.knob, kept]
        subprocess.run([asked.prune, f"{asked.pack}/parts.bin", *map(str, where)], check=True)
        pruned = time.perf_counter()
        words = ["pack", "render", asked.pack, "--kept", kept, "-o", asked.o]
        words += ["--spp", str(SAMPLES), "--seed", str(asked.seed), "--overwrite"]
        subprocess.run([sys.executable, "-m", "lodbench", *words], check=True)
    seconds = {"prune": pruned - start, "draw": time.perf_counter() - pruned}
    print(json.dumps({"stages": seconds}))


if __name__ == "__main__":
    main()
