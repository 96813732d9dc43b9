"""What is done in a round of a soak? Drawn from one seed, whole, before anything is started."""

import random
from dataclasses import dataclass, fields

from bench.studies.soak.damage import FRAME_DAMAGES, MANIFEST_DAMAGES, PLANTS
from bench.studies.soak.looks import FRAMES, LOOKS

SIGNALS = ("INT", "TERM", "HUP", "KILL")
STREAMS = {
    "kept": "",
    "no stdout": " >&-",
    "no stderr": " 2>&-",
    "neither": " >&- 2>&-",
    "full stdout": " >/dev/full",
    "full stderr": " 2>/dev/full",
    "reader gone": "",
}
"""Where a program's output goes, as a shell writes it. ``kept`` goes to files that are judged."""

NAMES = ("out", "two words", "ümläut", "deep/er/out", "-o", "a'b\"c$d", "100%", "link")


class Written:
    """What is written in short: only what differs from the ordinary."""

    def __str__(self) -> str:
        """Write the name of the kind, and every field that is not what it is by default."""
        given = [(each.name, getattr(self, each.name), each.default) for each in fields(self)]  # type: ignore[arg-type]
        words = [f"{name}={_short(value)}" for name, value, usual in given if value != usual]
        return f"{type(self).__name__}({', '.join(words)})"


def _short(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.3f}"
    if isinstance(value, tuple):
        return " ".join(map(str, value))
    return str(value)


@dataclass(frozen=True)
class Moment(Written):
    """When something happens to a program: both counts are reached, and some seconds passed.

    cpu_s   that the program itself has worked for, which load on the machine does not change
    frames  that it has finished
    """

    cpu_s: float
    frames: int
    then_s: float


@dataclass(frozen=True)
class Hit(Written):
    """A signal to a running program.

    target  program, group (as a terminal sends it) or worker (one of its processes)
    pick    which worker, as a fraction of how many there are
    again   the same signal once more, 10 ms later
    """

    signal: str
    target: str
    moment: Moment
    pick: float
    again: bool


@dataclass(frozen=True)
class Command(Written):
    """A run of the program.

    verb    render, long (a frame of minutes, in a folder of its own), verify, repair, ids, count
    stem    of the frames' names, before the number
    flags   of render
    stream  where its output goes, one of STREAMS
    wait_s  that the first command of a burst has worked for when this one starts
    """

    verb: str
    look: str = "plain"
    stem: str = "a"
    frames: tuple[int, ...] = FRAMES
    flags: tuple[str, ...] = ()
    stream: str = "kept"
    wait_s: float = 0.0
    hit: Hit | None = None


@dataclass(frozen=True)
class Harm(Written):
    """Damage to a file: its kind, which file and where in it, as fractions."""

    kind: str
    pick: float
    place: float


@dataclass(frozen=True)
class Burst(Written):
    """Commands at once on one folder; what happens to its files and its disk meanwhile, if so."""

    commands: tuple[Command, ...]
    meanwhile: Harm | None = None
    freeze: Moment | None = None


Step = Burst | Harm


@dataclass(frozen=True)
class Round:
    """One folder, from its first command to the last.

    disk_kb  what the folder's disk holds; None for the disk that the soak runs on
    """

    number: int
    folder: str
    disk_kb: int | None
    steps: tuple[Step, ...]


def plan_round(seed: int, number: int, clusters: bool = True) -> Round:
    """Draw a round: the same for the same seed and number, whatever other rounds did."""
    chance = random.Random(f"{seed}/{number}")
    small = chance.random() < 0.25
    disk_kb = chance.randrange(24, 240) if small else None
    looks = chance.sample(sorted(LOOKS), chance.choice((1, 2, 3)))
    steps: list[Step] = []
    for _ in range(chance.randint(2, 4)):
        steps.append(_burst(chance, looks, small, clusters))
        if chance.random() < 0.6:
            steps += [_harm(chance) for _ in range(chance.choice((1, 1, 2, 3)))]
    return Round(number, chance.choice(NAMES), disk_kb, tuple(steps))


def _burst(chance: random.Random, looks: list[str], small: bool, clusters: bool) -> Burst:
    if chance.random() < 0.2:
        return _rivals(chance)
    several = chance.choices((1, 2, 3, 4), (10, 7, 2, 1))[0]
    on_cluster = clusters and chance.random() < 0.1
    commands = [_command(chance, looks, on_cluster and not k) for k in range(several)]
    meanwhile = _harm(chance) if chance.random() < 0.15 else None
    freeze = _moment(chance) if small and chance.random() < 0.3 else None
    return Burst(tuple(commands), meanwhile, freeze)


def _rivals(chance: random.Random) -> Burst:
    """Draw renders that want the same frames at once, of equal settings or of others."""
    several = chance.choice((2, 2, 3, 4))
    looks = sorted(LOOKS) if chance.random() < 0.7 else [chance.choice(sorted(LOOKS))]
    waits = [chance.choice((0.0, chance.uniform(0.0, _STARTS_S))) for _ in range(several)]
    commands = [
        Command("render", looks[k % len(looks)], wait_s=wait) for k, wait in enumerate(waits)
    ]
    return Burst(tuple(commands))


def _command(chance: random.Random, looks: list[str], on_cluster: bool) -> Command:
    verbs = ("render", "long", "verify", "repair", "ids", "count")
    verb = "render" if on_cluster else chance.choices(verbs, (28, 2, 5, 5, 1, 1))[0]
    first, last = sorted(chance.choices(FRAMES, k=2)) if chance.random() < 0.4 else (1, FRAMES[-1])
    frames = list(range(first, last + 1))
    if chance.random() < 0.1:
        chance.shuffle(frames)
    kept = chance.random() < 0.75
    hit = None if chance.random() < 0.45 and verb != "long" else _hit(chance, verb, on_cluster)
    return Command(
        verb,
        chance.choice(looks),
        "b" if chance.random() < 0.1 else "a",
        tuple(frames),
        _flags(chance, on_cluster),
        "kept" if kept else chance.choice(list(STREAMS)),
        chance.choice((0.0, chance.uniform(0.0, _STARTS_S))),
        hit,
    )


def _flags(chance: random.Random, on_cluster: bool) -> tuple[str, ...]:
    flags: list[str] = []
    if chance.random() < 0.12:
        flags += ["--overwrite"]
    if chance.random() < 0.5:
        flags += ["--threads", str(chance.choice((1, 2, 4)))]
    if chance.random() < 0.06:
        flags += ["--preview"]
    if on_cluster:
        flags += ["--cluster", str(chance.choice((1, 2)))]
    return tuple(flags)


def _hit(chance: random.Random, verb: str, on_cluster: bool) -> Hit:
    targets = ("program", "group", "worker") if verb in ("render", "repair") else ("program",)
    weights = (1, 1, 6) if on_cluster else (3, 3, 1)
    target = chance.choices(targets, weights[: len(targets)])[0]
    kind = "KILL" if target == "worker" else chance.choice(SIGNALS)
    moment = _moment(chance)
    if verb == "long":  # it finishes no frame, and while another process renders it only waits
        moment = Moment(STARTED_S, 0, chance.uniform(0.0, 6.0))
    return Hit(kind, target, moment, chance.random(), chance.random() < 0.2)


def _moment(chance: random.Random) -> Moment:
    """Half of all moments lie before the first frame, where most of the time goes."""
    if chance.random() < 0.5:
        return Moment(chance.uniform(STARTED_S, _STARTS_S), 0, 0.0)
    return Moment(STARTED_S, chance.randrange(len(FRAMES)), chance.uniform(0.0, 0.1))


_STARTS_S = 2.0
STARTED_S = 0.4
"""Seconds of work after which the interpreter has surely handed over to the program.

What a signal does to an interpreter that is still starting is not the program's to promise."""


def _harm(chance: random.Random) -> Harm:
    kinds = chance.choices((FRAME_DAMAGES, MANIFEST_DAMAGES, PLANTS), (6, 4, 1))[0]
    return Harm(chance.choice(list(kinds)), chance.random(), chance.random())
