"""`lodbench doctor`: what works on this machine, what is kept on it, and what plug-ins break."""

import os
import platform
import shutil
import sys
from typing import Any

import click

from bench.cli.flags import StrictCommand
from bench.cli.kernel_cache import VARIABLE, kernel_cache_state
from bench.cli.output import Output, table
from lod.errors import InputError
from scenes.processes.cache import VARIABLE as CACHE

PACKAGES = ("lodbench", "mitsuba", "drjit", "OpenEXR", "numpy", "scipy", "numba", "colour-science")


@click.command("doctor", cls=StrictCommand, json="One JSON object on stdout, or per NAME.")
@click.option("--clear-cache", is_flag=True, help="Remove what is kept; the next command makes it.")
@click.option(
    "--check",
    "names",
    multiple=True,
    metavar="NAME|all",
    help="Hold a metric or representation, or all that are installed, against the rules.",
)
def command(clear_cache: bool, names: tuple[str, ...], out: Output) -> None:
    """Say which renderer variants work here, and what memory, disk and versions there are.

    Grown trees, their tables and compiled kernels are kept so that commands start at once. Nothing
    needs them. LODBENCH_CACHE names another folder.
    """
    if names:
        _check(names, out)
        return
    if clear_cache:
        _clear_cache()
    found = examine()
    out.record(found)
    _say(out, found)


def examine() -> dict[str, Any]:
    """Collect everything that `doctor` reports."""
    import psutil

    from bench.records.provenance import cpu_name, package_version
    from scenes.processes.cache import cache_contents, writable_cache
    from scenes.render.pictures import ffmpeg_path
    from scenes.render.variants import choose, probe

    cache = writable_cache()
    kinds = {each.kind: each for each in (cache_contents(cache) if cache else ())}
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
        "cache": cache,
        "cached": {k: {"files": e.entries, "bytes": e.size_bytes} for k, e in kinds.items()},
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
    kept = [f"{kind} {each['bytes'] / 1e6:.1f} MB" for kind, each in found["cached"].items()]
    kernels = found["kernels"]
    compiled = f"compiled for each run: no folder can be written to (set {VARIABLE} to one)"
    rows = [
        ("libLLVM", found["libllvm"] or "none that works: apt install libllvm19"),
        (
            "memory",
            f"{memory['available_bytes'] * gib:.1f} of {memory['total_bytes'] * gib:.1f} GiB free",
        ),
        ("disk", f"{disk['free_bytes'] * gib:.1f} GiB free in {disk['folder']}"),
        ("processor", f"{cpu['name']}, {cpu['threads']} threads, {cpu['usable']} usable here"),
        ("cache", found["cache"] or f"nothing is kept: no folder can be written to (set {CACHE})"),
        ("kept", ", ".join(kept) or "nothing yet"),
        ("kernels", str(kernels["folder"]) if kernels["kept"] else compiled),
        (
            "ffmpeg",
            found["ffmpeg"] or "none: no mp4 with --preview (pip install lodbench[preview])",
        ),
        ("Python", f"{found['python']} ({sys.executable})"),
    ]
    out.say(f"machine\n{table(rows)}")
    out.say(f"packages\n{table((name, v or 'missing') for name, v in found['packages'].items())}")


def _clear_cache() -> None:
    from scenes.processes.cache import clear_cache, writable_cache

    folder = writable_cache()
    if folder is None:
        rule = "the cache is a folder that can be written to, and there is none"
        raise InputError("--clear-cache", None, rule, f"set {CACHE} to a folder")
    clear_cache(folder)


def _check(names: tuple[str, ...], out: Output) -> None:
    from bench.conformance import broken_metric_rules, broken_plugin_rules
    from lod.metric import METRICS
    from scenes.plugins import METRIC, REPRESENTATION, installed

    rules = {"metric": broken_metric_rules, "representation": broken_plugin_rules}
    known = {"metric": (*METRICS, *installed(METRIC)), "representation": installed(REPRESENTATION)}
    theirs = [("metric", name) for name in installed(METRIC)]
    theirs += [("representation", name) for name in installed(REPRESENTATION)]
    chosen: list[tuple[str, str]] = []
    for name in names:
        found = [(kind, name) for kind, those in known.items() if name in those]
        found += theirs if name == "all" else []
        if not found and name == "all":
            cure = "try blake, or install a package that brings some (README: How to add yours)"
            rule = "no other package brings a metric or representation"
            raise InputError("--check", name, rule, cure)
        if not found:
            rule = f"a metric or representation: {', '.join(n for k in known.values() for n in k)}"
            raise InputError("--check", name, rule, "see `lodbench list`")
        chosen += found
    failed = []
    for kind, name in chosen:
        try:
            broken = rules[kind](name)
        except InputError as error:
            broken = {"can be used": [str(error)]}
        wrong = {rule: lines for rule, lines in broken.items() if lines}
        out.record({"name": name, "kind": kind, "broken": wrong})
        rows = [
            (rule, "kept" if not lines else line)
            for rule, lines in broken.items()
            for line in lines or [""]
        ]
        out.say(f"{name}, a {kind}\n{table(rows)}")
        failed += [name] if wrong else []
    if failed:
        raise click.ClickException(f"{', '.join(failed)}: not as the rules have it")
