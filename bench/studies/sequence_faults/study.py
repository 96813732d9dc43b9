"""Sequences that are killed, damaged, interrupted and starved of disk: do they end right?

Runs the program itself, with small frames, and does to it what nights do to renderers: it is killed
at random moments, its frames are damaged, it is interrupted, its disk fills up. Prints how often
the folder was right in the end.
"""

import json
import os
import random
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from bench.cli.main import INTERRUPTED
from bench.studies.sequence_faults.program_run import FRAMES, LONGEST_S, Place
from scenes.render.files.manifest import NAME, load_manifest
from scenes.render.mitsuba.variants import JIT_VARIANT, SCALAR_VARIANT


def kills(place: Place, times: int, seed: int = 0) -> dict[str, Any]:
    """SIGKILL a run of 20 frames and all its processes at random moments, and resume it.

    A moment is that of a random frame's end and up to twice a frame's time later.
    """
    chance = random.Random(seed)
    whole = place.render("whole")
    seconds = [sum(line["seconds"].values()) for line in whole.lines if "frame" in line]
    length, expected = sorted(seconds)[len(seconds) // 2], place.hashes("whole")
    right = partial = 0
    whole_when_killed = []
    for number in range(times):
        out = f"killed{number}"
        process = place.start(*place.command(out))
        _await_frames(place, out, chance.randrange(FRAMES), process)
        time.sleep(chance.uniform(0, 2 * length))
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        found = place.hashes(out) if (place.folder / out).exists() else {}
        partial += any(expected.get(name) != digest for name, digest in found.items())
        whole_when_killed.append(len(found))
        again = place.render(out)
        right += again.code == 0 and place.hashes(out) == expected and not place.litter(out)
        shutil.rmtree(place.folder / out)
    return {
        "frames": len(expected),
        "killed": times,
        "right after resuming": right,
        "partial files under a final name": partial,
        "frames whole when killed": sorted(whole_when_killed),
    }


def _await(path: Path, process: subprocess.Popen[str]) -> None:
    """Wait until a file is there, or the process has ended."""
    while process.poll() is None and not path.exists():
        time.sleep(0.002)


def _await_frames(place: Place, out: str, frames: int, process: subprocess.Popen[str]) -> None:
    """Wait until so many frames are whole, or the process has ended."""
    while process.poll() is None and len(list((place.folder / out).glob("*.exr"))) < frames:
        time.sleep(0.002)


def damage(place: Place, each: int, seed: int = 0) -> dict[str, Any]:
    """Truncate, flip a bit of, zero and swap so many frames each; verify and repair.

    Frames are swapped in pairs: an odd number counts as the next even one.
    """
    each += each % 2
    chance, frames = random.Random(seed), 4 * each + 10
    place.render("damaged", f"1-{frames}")
    expected = place.hashes("damaged")
    paths = [place.folder / "damaged" / name for name in sorted(expected)]
    chosen = chance.sample(paths, 4 * each)
    cut, flipped, zeroed, swapped = (chosen[k * each : (k + 1) * each] for k in range(4))
    for path in cut:
        os.truncate(path, chance.randrange(path.stat().st_size))
    for path in flipped:
        data = bytearray(path.read_bytes())
        data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        path.write_bytes(bytes(data))
    for path in zeroed:
        path.write_bytes(bytes(path.stat().st_size))
    for a, b in zip(swapped[::2], swapped[1::2], strict=True):
        other = b.read_bytes()
        b.write_bytes(a.read_bytes())
        a.write_bytes(other)
    looked = place.run("verify", "damaged", "--json")
    mended = place.run("verify", "damaged", "--json", "--repair")
    names = sorted(path.name for path in chosen)
    again = [line for line in mended.lines if line.get("repaired") == "rendered again"]
    return {
        "frames": frames,
        "damaged": len(chosen),
        "found": sum(Path(line["path"]).name in names for line in looked.lines[:-1]),
        "found beside": sum(Path(line["path"]).name not in names for line in looked.lines[:-1]),
        "rendered again": len(again),
        "exactly those": sorted(Path(line["path"]).name for line in again) == names,
        "hashes as before": place.hashes("damaged") == expected,
        "exit codes": [looked.code, mended.code],
    }


def repeats(place: Place, times: int) -> dict[str, Any]:
    """Render the same frames several times, with 1, 2 and 4 threads, in fresh processes."""
    found = []
    for number in range(times):
        place.render(f"repeat{number}", "1-5")
        found.append(place.hashes(f"repeat{number}"))
    for threads in (1, 2, 4):
        place.render(f"threads{threads}", "1-5", "--threads", str(threads))
        found.append(place.hashes(f"threads{threads}"))
    for frame in (4, 2, 5, 3, 1):
        place.render("order", str(frame))
    found.append(place.hashes("order"))
    distinct = {name: {each.get(name) for each in found} for name in found[0]}
    return {
        "runs": len(found),
        "frames": len(found[0]),
        "hashes of each frame": sorted({len(each) for each in distinct.values()}),
    }


def interrupts(place: Place, times: int, seed: int = 0) -> dict[str, Any]:
    """Interrupt a long frame at random moments, with one Ctrl-C and with two in a row."""
    chance, waits, codes, left = random.Random(seed), [], [], 0
    for number in range(times):
        out = f"interrupted{number}"
        process = place.start(*place.command(out), "--size", "640x360", "--spp", "4096")
        _await(place.folder / out / NAME, process)
        time.sleep(chance.uniform(0.0, 6.0))
        children = _descendants(process.pid)
        start = time.monotonic()
        os.killpg(process.pid, signal.SIGINT)
        if number % 2:
            time.sleep(0.01)
            os.killpg(process.pid, signal.SIGINT)
        process.communicate(timeout=LONGEST_S)
        waits.append(time.monotonic() - start)
        codes.append(process.returncode)
        time.sleep(0.2)
        alive = [child for child in children if _runs(child)]
        left += bool(alive or ((place.folder / out).exists() and place.litter(out)))
    return {
        "interrupted": times,
        f"exit {INTERRUPTED}": codes.count(INTERRUPTED),
        "longest wait s": round(max(waits), 2),
        "longest wait s, twice": round(max(waits[1::2], default=0.0), 2),
        "something left behind": left,
    }


def _descendants(process: int) -> list[int]:
    import psutil

    return [child.pid for child in psutil.Process(process).children(recursive=True)]


def _runs(process: int) -> bool:
    """Say whether a process is at work; an ended one that nobody has collected is not."""
    import psutil

    try:
        return bool(psutil.Process(process).status() != psutil.STATUS_ZOMBIE)
    except psutil.NoSuchProcess:
        return False


def full_disk(place: Place, times: int) -> dict[str, Any]:
    """Render onto a disk with room for a few frames more each time, and a read-only one."""
    clear = harmed = 0
    place.render("whole")
    expected = place.hashes("whole")
    for number in range(times):
        mount = place.folder / f"disk{number}"
        mount.mkdir()
        full = number % 2 == 0
        size = f"size={16 + 4 * number}k" if full else "size=4m"
        subprocess.run(["mount", "-t", "tmpfs", "-o", size, "tmpfs", str(mount)], check=True)
        try:
            clear += _refused(place, mount, full, number)
            found = place.hashes(mount.name)
            known = load_manifest(mount).frames if (mount / "manifest.json").exists() else {}
            for name, digest in found.items():
                harmed += expected[name] != digest or known[name]["sha256"] != digest
        finally:
            subprocess.run(["umount", str(mount)], check=True)
    return {"points": times, "clear errors": clear, "finished frames harmed": harmed}


def _refused(place: Place, mount: Path, full: bool, number: int) -> bool:
    """Render onto a disk that is too small, or that turns read-only after a few frames."""
    process = place.start(*place.command(mount.name))
    if not full:
        deadline = time.monotonic() + LONGEST_S
        while len(place.hashes(mount.name)) <= number % 10 and time.monotonic() < deadline:
            time.sleep(0.005)
        frozen = ["mount", "-o", "remount,ro", str(mount)]
        while subprocess.run(frozen, stderr=subprocess.DEVNULL).returncode:
            time.sleep(0.001)  # busy while a file is open for writing
    _, err = process.communicate(timeout=LONGEST_S)
    says = "the disk is full" if full else "read-only"
    return process.returncode in (1, 2) and says in err.lower() and err.count("\n") == 1


MEASUREMENTS: dict[str, tuple[Callable[..., dict[str, Any]], int, Sequence[str]]] = {
    "kills": (kills, 50, (SCALAR_VARIANT,)),
    "damage": (damage, 50, (SCALAR_VARIANT,)),
    "repeats": (repeats, 10, (SCALAR_VARIANT, JIT_VARIANT)),
    "interrupts": (interrupts, 20, (SCALAR_VARIANT, JIT_VARIANT)),
    "full_disk": (full_disk, 20, (SCALAR_VARIANT,)),
}
"""By name: the function that measures, how often, and in which variants."""


@click.command()
@click.argument("names", nargs=-1, type=click.Choice(list(MEASUREMENTS)))
@click.option("--times", type=int, help="Instead of the number that is asked for.")
def command(names: tuple[str, ...], times: int | None) -> None:
    """Measure and print."""
    for name in names or MEASUREMENTS:
        measure, number, variants = MEASUREMENTS[name]
        for variant in variants:
            with tempfile.TemporaryDirectory() as folder:
                found = measure(Place(Path(folder), variant), times or number)
            click.echo(json.dumps({"measurement": name, "variant": variant, **found}))
