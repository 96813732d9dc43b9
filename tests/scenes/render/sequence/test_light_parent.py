"""The process that keeps the manifest never loads the renderer or the scene."""

import subprocess
import sys

HEAVY = ("mitsuba", "drjit", "numba", "OpenEXR", "scipy", "colour")

CODE = f"""
import sys
import bench.cli.commands.render, bench.cli.progress
import scenes.render.sequence.sequence, scenes.render.sequence.worker
import scenes.render.mitsuba.variants
print(*[name for name in {HEAVY} if name in sys.modules])
"""


def test_what_renders_stays_in_the_child():
    done = subprocess.run(
        [sys.executable, "-c", CODE],
        capture_output=True,
        text=True,
        env={"PYTHONPATH": ":".join(sys.path)},
    )
    assert (done.returncode, done.stdout.strip()) == (0, ""), done.stderr
