"""`lodbench run`: measure, write the record, say what held."""

import hashlib
import time
import uuid
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import CompletionItem

from bench.cli.flags import StrictCommand, complete_preset, memory_flag_of_all, value_option
from bench.cli.output import Output, duration_text, progress_bar, table, tell_first_run
from bench.runs import CaseExecutor, dask_executor
from lod.errors import InputError
from scenes.files import make_folder
from scenes.presets.values import LARGEST_SEED
from scenes.processes.ownership import owned

if TYPE_CHECKING:
    from bench.experiment import Own
    from bench.records.claims import Claim
    from bench.runs import Journal, RunRequest


def _complete(_: click.Context, __: click.Parameter, begun: str) -> list[CompletionItem]:
    from bench.experiment import ALL, experiments

    names = {name for each in experiments().values() for name in (each.name, *each.topics)}
    return [CompletionItem(name) for name in (*sorted(names), ALL) if name.startswith(begun)]


@click.command("run", cls=StrictCommand, json="One JSON object per experiment on stdout.")
@click.argument("experiments", metavar="EXPERIMENT...|all", nargs=-1, shell_complete=_complete)
@click.option("--quick", is_flag=True, help="Fewer points and fields: minutes instead of hours.")
@click.option(
    "--seed", type=click.IntRange(0, LARGEST_SEED), default=0, help="Of all fields; 0 by default."
)
@click.option("-o", "folder", required=True, metavar="DIR", help="Folder for the records.")
@click.option("--again", is_flag=True, help="Measure again what is done already.")
@value_option("--metric", metavar="NAME", help="An installed metric beside the built-in ones.")
@click.option("--stems", metavar="FILE", help="A map of trees for `run spread`: a CSV of x,y in m.")
@click.option(
    "--preset",
    metavar="PRESET",
    shell_complete=complete_preset,
    help="Measure a preset of your own in place of the built-in worlds.",
)
@click.option(
    "--cluster", metavar="N|ADDRESS|FILE", help="Workers to start here, or a Dask scheduler."
)
@click.option("--command", "words", metavar="WORDS", help="A program's call: {scene} {exr} {knob}.")
@click.option("--pack", metavar="DIR", help="The pack that the program renders.")
@click.option("--settings", metavar="X,…", help="Values of {knob}, as 1,2,4; 1 by default.")
@click.option("--repeats", type=click.IntRange(1), help="Calls of each setting; 3 by default.")
@click.option("--program", metavar="NAME", help="Name and version of the program.")
@click.option("--who", metavar="NAME", help="Who submits; the record names it.")
@click.option("--baseline", metavar="JSON", help="Record of blake; by default the published one.")
@click.option("--diagnose", is_flag=True, help="Render likely mistakes from the pack's recipe.")
@memory_flag_of_all
def command(
    experiments: tuple[str, ...],
    quick: bool,
    seed: int,
    folder: str,
    again: bool,
    metric: str | None,
    stems: str | None,
    preset: str | None,
    cluster: str | None,
    words: str | None,
    out: Output,
    **of_program: Any,
) -> None:
    """Run experiments; each writes one record (JSON) and says in a few lines what was found.

    The same command again goes on where it was stopped. A folder has one such process at a time.
    `run methods --command` calls any program instead: for each setting of its knob and repeat, with
    times and memory measured from outside and its pictures scored.
    """
    from bench.runs import journal

    if words is not None:
        _run_program(experiments, words, folder, out, **of_program)
        return
    own: dict[Own, Any] = {"metric": metric, "stems": stems, "preset": preset}
    asked = _asked(experiments, cluster, quick, seed, own)
    place = make_folder(folder)
    tell_first_run()
    with owned(place, uuid.uuid4().hex, "measures there", out.note):
        kept = journal(place)
        if again:
            for each in asked:
                kept.discard(each)
        with dask_executor(cluster, out.note) as spread:
            failed = _run_all(out, kept, asked, spread)
    if failed:
        raise click.ClickException(f"{len(failed)} of {len(asked)} failed: {', '.join(failed)}")


def _run_program(
    named: tuple[str, ...],
    words: str,
    folder: str,
    out: Output,
    pack: str | None,
    settings: str | None,
    repeats: int | None,
    **rest: Any,
) -> None:
    from bench.packs.make import read_pack
    from bench.submissions.entry import page
    from bench.submissions.executable import NAMES, run_program, words_of

    if named != ("methods",):
        raise InputError("--command", " ".join(named), "a program enters `run methods` alone")
    if pack is None:
        raise InputError("--command", "alone", "it renders a pack", "add --pack DIR")
    read_pack(Path(pack))
    try:
        knob = sorted({float(each) for each in (settings or "1").split(",")})
    except ValueError:
        raise InputError("--settings", settings, "numbers", "try 1,4,16") from None
    words_of(words, dict.fromkeys(NAMES, "x"))
    texts: dict[str, Any] = {name: rest.pop(name) or "unnamed" for name in ("who", "program")}
    place = make_folder(folder)
    with owned(place, uuid.uuid4().hex, "measures there", out.note):
        with progress_bar("call") as show:
            path, record = run_program(
                Path(pack), words, knob, repeats or 3, place, **texts, **rest, show=show
            )
        out.record(record)
        out.say(f"{page(record)}\n{path}")


def _asked(
    named: tuple[str, ...], cluster: str | None, quick: bool, seed: int, given: dict["Own", Any]
) -> list["RunRequest"]:
    """Check what is asked for; experiments that are timed stay on this machine."""
    from bench.experiment import ALL, experiments, topics_named
    from bench.runs import RunRequest

    every = experiments()
    if not named:
        raise InputError("EXPERIMENT", named, "at least one, or all", f"try {next(iter(every))}")
    chosen = {name: tuple(mine) for name, mine in topics_named(named, "EXPERIMENT").items()}
    for name in chosen:
        if cluster is not None and every[name].timed and ALL not in named:
            able = ", ".join(n for n, each in every.items() if not each.timed)
            raise InputError("--cluster", name, f"experiments without times: {able}", "leave it")
    for own in [own for own, value in given.items() if value is not None]:
        able_to = [name for name, each in every.items() if each.accepting(own, each.topics)]
        others = [name for name, mine in chosen.items() if not every[name].accepting(own, mine)]
        if others and ALL not in named:
            rule = f"experiments that try {own.rstrip('s')}s: {', '.join(able_to)}"
            raise InputError(f"--{own}", ", ".join(others), rule, f"run {able_to[0]}")
        given[own] = _read_own(own, given[own])
        if own == "preset":  # what has worlds of its own alone is not asked
            chosen = {name: every[name].accepting(own, mine) for name, mine in chosen.items()}
    return [RunRequest(name, mine, quick, seed, **given) for name, mine in chosen.items() if mine]


def _read_own(own: "Own", value: str) -> Any:
    """Return a thing of a user's own as topics take it; what is wrong is said before a run."""
    if own == "metric":
        from lod.metric import METRICS
        from scenes.plugins import metric_by_name

        metric_by_name(value)
        if value in METRICS:
            raise InputError("--metric", value, "one of another package", "ours are tried anyhow")
        return value
    if own == "stems":
        from scenes.field.patterns import read_stems

        read_stems(Path(value))
        return str(Path(value).resolve()), hashlib.sha256(Path(value).read_bytes()).hexdigest()
    from scenes.presets.load import load_preset

    preset = load_preset(value)
    if not any(each.density > 0 for each in preset.species.values()):
        rule = "a preset with species, whose counts have a law"
        raise InputError("--preset", value, rule, "add a table [species.NAME] with a density")
    return Path(value).name, preset


def _run_all(
    out: Output, kept: "Journal", asked: Sequence["RunRequest"], spread: CaseExecutor
) -> list[str]:
    """Run the experiments that are not done, and give the names of those that failed.

    Of several, one that fails does not end the others.
    """
    from bench.experiment import experiments
    from bench.records.records import read_record
    from bench.runs import run_request

    done = {each.name: path for each in asked if (path := kept.record_of(each))}
    for name, path in done.items():
        out.note(f"lodbench: {name} is done already (--again measures anew)")
        _tell(out, name, path, read_record(path).claims, True)
    left = [each for each in asked if each.name not in done]
    expected_s = [
        experiments()[each.name].seconds(each.topics, "quick" if each.quick else "full")
        for each in left
    ]
    planned = spent = 0.0
    failed: list[str] = []
    for number, each in enumerate(left):
        pace = spent / planned if planned else 1.0  # of what is finished
        expected = f"about {duration_text(pace * expected_s[number])}"
        if number + 1 < len(left):
            expected += f"; {duration_text(pace * sum(expected_s[number:]))} for all that is left"
        out.note(f"lodbench: {each.name}, {len(done) + number + 1} of {len(asked)}: {expected}")
        planned_topics = () if each.preset else each.topics
        for topic in (experiments()[each.name].topics[name] for name in planned_topics):
            for line in topic.plan(**topic.sizes("quick" if each.quick else "full")):
                out.note(f"  {line}")
        start = time.perf_counter()
        try:
            with progress_bar("case") as progress:
                experiment = experiments()[each.name]
                path, record = run_request(experiment, each, kept, spread, progress)
        except Exception as error:
            if len(asked) == 1:
                raise
            out.note(f"lodbench: {each.name} failed: {type(error).__name__}: {error}")
            failed.append(each.name)
            continue
        planned, spent = planned + expected_s[number], spent + time.perf_counter() - start
        _tell(out, each.name, path, record.claims, False)
    return failed


_MOST = 5  # claims that a run prints; the report has all


def _tell(out: Output, name: str, path: Path, claims: tuple["Claim", ...], kept: bool) -> None:
    from bench.report.document import summarise_verdicts, verified

    data = [each.as_json() for each in claims]
    out.record({"experiment": name, "record": str(path), "kept": kept, "claims": data})
    of = {kind: [c for c in claims if c.kind == kind] for kind in ("measurement", "verification")}
    said = summarise_verdicts(of["measurement"]), verified(of["verification"])
    order = "refuted", "inconclusive", "holds", "expected violation"

    def place(c: "Claim") -> tuple[bool, bool, int]:
        sound = c.kind == "verification" and c.verdict != "refuted"
        return not c.headline, sound, order.index(c.verdict)

    first = sorted(claims, key=place)[:_MOST]
    rows = [(c.verdict_text, c.sentence, c.measured_text) for c in first]
    left = len(claims) - len(first)
    lines = [f"{name}: {path}", *(f"  {text}" for text in said if text), table(rows)]
    more = f"{left} more claim{'s' * (left > 1)} and the plots" if left else "the plots"
    lines += [f"  lodbench report {path.parent}   writes {more} into report.html"]
    out.say("\n".join(filter(None, lines)))
