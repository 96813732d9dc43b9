"""`lodbench doctor`: what works on this machine, and what is missing."""

import os
import platform
import shutil
import sys
from typing import Any

import click

from bench.cli.flags import StrictCommand
from bench.cli.kernel_cache import VARIABLE, kernel_cache_state
from bench.cli.output import Output, output, table
from scenes.processes.cache import VARIABLE as CACHE

PACKAGES = ("lodbench", "mitsuba", "drjit", "OpenEXR", "numpy", "scipy", "numba", "colour-science")


@click.command("doctor", cls=StrictCommand)
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(as_json: bool) -> None:
    """Mitsuba's variants, LLVM, memory, disk, processor and versions."""
    with output(as_json) as out:
        found = examine()
        out.record(found)
        _say(out, found)


def examine() -> dict[str, Any]:
    """Collect everything that `doctor` reports."""
    import psutil

    from bench.records.provenance import cpu_name, package_version
    from scenes.processes.cache import writable_cache
    from scenes.render.pictures import ffmpeg_path
    from scenes.render.variants import choose, probe

    seen, memory, disk = probe(), psutil.virtual_memory(), shutil.disk_usage(os.getcwd())
    return {
        "variants": seen.variants,
        "auto": choose("auto"),
        "libllvm": seen.libllvm,
        "libraries": seen.libraries,
        "memory": {"total_bytes": memory.total, "available_bytes": memory.available},
        "disk": {"folder": os.getcwd(), "total_bytes": disk.total, "free_bytes": disk.free},
        "cpu": {
            "name": cpu_name(),
            "cores": psutil.cpu_count(logical=False),
            "threads": psutil.cpu_count(),
            "usable": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else None,
        },
        "cache": writable_cache(),
        "kernels": kernel_cache_state(),
        "ffmpeg": ffmpeg_path(),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "packages": {name: package_version(name) for name in PACKAGES},
    }


def _say(out: Output, found: dict[str, Any]) -> None:
    gib = 1 / 2**30
    memory, disk, cpu = found["memory"], found["disk"], found["cpu"]
    works = [
        (name, "works" if answer is True else answer) for name, answer in found["variants"].items()
    ]
    out.say(f"variants (auto is {found['auto']})\n{table(works)}")
    rows = [
        ("libLLVM", found["libllvm"] or "none that works: apt install libllvm19"),
        (
            "memory",
            f"{memory['available_bytes'] * gib:.1f} of {memory['total_bytes'] * gib:.1f} GiB free",
        ),
        ("disk", f"{disk['free_bytes'] * gib:.1f} GiB free in {disk['folder']}"),
        ("processor", f"{cpu['name']}, {cpu['threads']} threads, {cpu['usable']} usable here"),
        ("cache", found["cache"] or f"nothing is kept: no folder can be written to (set {CACHE})"),
        ("kernels", _kernels(found["kernels"])),
        ("temporary", found["kernels"]["temporary"] or "no folder: set TMPDIR to one"),
        (
            "ffmpeg",
            found["ffmpeg"] or "none: no mp4 with --preview (pip install lodbench[preview])",
        ),
        ("Python", f"{found['python']} ({sys.executable})"),
    ]
    out.say(f"machine\n{table(rows)}")
    out.say(f"packages\n{table((name, v or 'missing') for name, v in found['packages'].items())}")


def _kernels(state: dict[str, Any]) -> str:
    """Say where compiled kernels are kept, or that they are not."""
    if state["kept"]:
        return str(state["folder"])
    return f"compiled for each run: no folder can be written to (set {VARIABLE} to one)"
