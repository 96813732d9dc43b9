"""Write the figures that pages quote from records, between the marks of their blocks.

A block begins with ``<!-- figures: NAME -->``, or with a name and words that its function takes
(``<!-- figures: claims_of figure blake/person/* -->``), and ends with ``<!-- end of figures -->``.
What stands between is written from records: those of studies, soaks and the fuzzer, and the
claims and tables of the reference run. `make docs` fills all pages, and a test compares. A block
says so where its record is not there yet.
"""

import errno
import json
import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from bench.experiments.registry import EXPERIMENTS
from bench.records.records import read_record
from bench.records.study_record import StudyRecord, read_study_record
from bench.report.reference_tables import (
    JudgedClaim,
    changed_table,
    chosen_table,
    experiment_table,
    judged_claims,
    markdown_table,
    short_commits,
)
from bench.studies.acting import study as acting_study
from bench.studies.defocus import saved_share
from bench.studies.grass.study import edges_of

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "results"
REFERENCE, STUDIES = RESULTS / "reference", RESULTS / "studies"
PAGES = (
    "README.md",
    "docs/depth-of-field.md",
    "docs/framing.md",
    "docs/promises.md",
    "results/README.md",
    "results/acting.md",
    "results/changed.md",
    "results/cost.md",
    "results/haze.md",
    "results/law.md",
    "results/motion.md",
    "results/pictures.md",
    "results/rivals.md",
)
_BLOCK = re.compile(r"(<!-- figures: ([^>]+) -->\n).*?(<!-- end of figures -->)", re.S)


def filled(text: str) -> str:
    """Give a page with the figures of all its blocks. Raises KeyError for an unknown block."""
    return _BLOCK.sub(lambda found: f"{found[1]}\n{_figures(found[2])}\n\n{found[3]}", text)


def claims() -> str:
    """Write the claims of the reference run that the report's first screen chooses."""
    return chosen_table(_reference())


def claims_of(experiment: str, *patterns: str) -> str:
    """Write claims of an experiment of the reference run: what it measured, or those named."""
    return experiment_table(_reference(), experiment, *patterns)


def table_of(experiment: str, number: str = "0") -> str:
    """Write a table of an experiment's record: 0 is its summary, those after it its other ones."""
    paths = sorted(REFERENCE.glob(f"{experiment}-*.json"))
    if not paths:
        raise FileNotFoundError(errno.ENOENT, "no record", str(REFERENCE / f"{experiment}-….json"))
    record, shown = read_record(paths[0]), EXPERIMENTS[experiment]
    others = shown.tables(record) if shown.tables else ()
    titled = (("", shown.summary(record)), *others)
    heads, rows = titled[int(number)][1]
    return markdown_table(heads, rows)


def changed() -> str:
    """Write which verdicts of the reference run differ from those of the one before it."""
    return changed_table(RESULTS / "before" / "claims.csv", _reference())


def start() -> str:
    """Write how long commands take from the shell to their answer."""
    record = _study("start")
    rows = []
    for name, each in record.figures.items():
        interval = f" ({each['low']:.2f} to {each['high']:.2f})" if each["low"] else ""
        seconds = (f"{each[key]:.2f}" for key in ("imports_s", "own_s", "command_s"))
        rows.append((name, *seconds, f"{each['ratio']:.2f}{interval}"))
    heads = "command", "imports [s]", "trace [s]", "command [s]", "command ÷ (imports + trace)"
    return f"{markdown_table(heads, rows)}\n\n{_origin(record)}"


def framing() -> str:
    """Write displayed over predicted of panoramas and pairs."""
    record = _study("framing")
    rows = [
        (
            name,
            f"{each['objects_a_field']:,.0f}",
            _interval(each["objects"]),
            _interval(each["parts"]),
        )
        for name, each in record.figures.items()
    ]
    heads = "framing", "objects a field", "objects ÷ law's (95 %)", "parts ÷ law's (95 %)"
    how = f"{record.settings['fields']} fields of people. {_origin(record)}"
    return f"{markdown_table(heads, rows)}\n\n{how}"


def defocus() -> str:
    """Write what a lens saves and costs, by distance."""
    record = _study("defocus")
    parts, errors = record.figures["parts"], record.figures["errors"]
    knows, does_not = errors.values()
    rows = []
    for band, each in parts.items():
        share = saved_share(each)
        saved = "-" if share is None else f"{100 * share:.0f} %"
        flips = [_error(one[band]) if band in one else "-" for one in (knows, does_not)]
        if band != "of these kept near though blurred":
            floor = f"{knows[band]['floor']:.4f}" if band in knows else "-"
            rows.append((band, f"{each['no_lens']:,}", saved, *flips, floor))
    whole = list(knows)[-1]
    one = [_error(each[whole]) for each in (knows, does_not)]
    rows.append((f"all, {whole}", "-", "-", *one, f"{knows[whole]['floor']:.4f}"))
    heads = "distance", "parts", "saved", "FLIP, knows of the lens", "does not know", "floor"
    law = _interval(record.figures["law"])
    said = record.settings
    how = (
        f"`{said['preset']}`, f/{said['f_stop']:g}, focus at {said['focus']:g} m, parts in "
        f"{said['parts_size']}. Errors in {said['size']}, extrapolated from {_listed(said['spp'])} "
        f"samples a pixel to pictures without noise, over {said['pairs']} pairs of seeds."
    )
    of_law = f"Over {said['fields']} fields all round the parts are {law} of those predicted."
    return f"{markdown_table(heads, rows)}\n\n{how} {of_law} {_origin(record)}"


def grass() -> str:
    """Write what grass costs a frame and by its density, and how bright it is across its limit."""
    record = _study("grass")
    said, figures = record.settings, record.figures
    frames = []
    for name, each in figures["frames"].items():
        spreads = (_spread(each[key]) for key in ("cpu_s", "wall_s", "peak_gb"))
        shapes = (f"{each[key]:,}" if key in each else "-" for key in ("sticks", "triangles"))
        frames.append((name, *spreads, *shapes))
    counts = []
    for each in figures["counts"]:
        cost: tuple[str, ...] = "does not fit", "-", "-", "-"
        if "refused" not in each:
            posed = "-" if each["pose_s"] is None else f"{each['pose_s']:.2f}"
            held = f"{each['peak_bytes'] / 1e9:.2f}"
            cost = f"{each['parts']:,}", f"{each['prune_s']:.2f}", posed, held
        counts.append((f"{each['density']:g}", each["metric"], *cost))
    suns = list(figures["edge"])
    starts, ends = edges_of(said["width"])
    bands = [
        (f"{low:g} to {high:g} m", *(_band(figures["edge"][sun][k]) for sun in suns))
        for k, (low, high) in enumerate(zip(starts, ends, strict=True))
    ]
    of_frames = "`meadow`", "processor [s]", "clock [s]", "memory [GB]", "sticks", "triangles"
    of_counts = "tufts/m²", "metric", "parts", "prune [s]", "pose [s]", "memory of `count` [GB]"
    texts = (
        markdown_table(of_frames, frames),
        f"Medians of {said['turns']} turns, least to greatest; {said['size']}, {said['spp']} "
        "samples a pixel, each frame in a process of its own, from its start to its end.",
        markdown_table(of_counts, counts),
        f"Grass alone, in a view of {said['count_size']}; processor seconds.",
        markdown_table(("distance", *(f"the sun {each}" for each in suns)), bands),
        f"Luminance at one pixel over that at a quarter (95 %), and rays that meet the band over "
        f"rays; grass alone on nearly level ground, {said['width']} pixels wide, {said['fields']} "
        f"worlds. {_origin(record)}",
    )
    return "\n\n".join(texts)


def _spread(each: Mapping[str, float]) -> str:
    return f"{each['median']:.2f} ({each['least']:.2f} to {each['greatest']:.2f})"


def _band(each: Mapping[str, float | None]) -> str:
    if each["luminance"] is None:
        return "-"
    interval = "" if each["low"] is None else f" ({each['low']:.3f} to {each['high']:.3f})"
    return f"{each['luminance']:.3f}{interval}; {each['rays']:.2f}"


def acting() -> str:
    """Write what actors cost and who may wait, as its study prints it."""
    parts = acting_study.read_record(RESULTS / "acting.json")
    return f"```\n{acting_study.page(parts)}\n```"


def tried() -> str:
    """Write a row for each soak on record, and a sentence for each run of the fuzzer."""
    heads = (
        *("what", "commit", "seconds", "rounds", "commands", "signals", "workers killed"),
        *("damages", "verdicts", "broken"),
    )
    table = markdown_table(heads, [_soak(each) for each in _records("soak")])
    fuzzed = (_fuzz(each) for each in _records("fuzz"))
    return "\n\n".join((table, _longest(_records("soak")), *fuzzed))


BLOCKS: Mapping[str, Callable[..., str]] = {
    "claims": claims,
    "claims_of": claims_of,
    "table_of": table_of,
    "changed": changed,
    "start": start,
    "framing": framing,
    "defocus": defocus,
    "grass": grass,
    "acting": acting,
    "tried": tried,
}


def _figures(block: str) -> str:
    try:
        name, *words = block.split()
        return BLOCKS[name](*words)
    except FileNotFoundError as missing:
        return f"Not measured yet: there is no {Path(str(missing.filename)).relative_to(ROOT)}."


@cache
def _reference() -> list[JudgedClaim]:
    return judged_claims(REFERENCE)


def _study(name: str) -> StudyRecord:
    return read_study_record(STUDIES / f"{name}.json")


def _records(folder: str) -> list[dict[str, Any]]:
    paths = sorted((RESULTS / folder).glob("*.json"))
    return [json.loads(path.read_text(encoding="utf-8")) for path in paths]


def _soak(record: dict[str, Any]) -> tuple[str, ...]:
    tried, source = record["tried"], record["provenance"]

    def total(begin: str) -> str:
        return f"{sum(n for name, n in tried.items() if name.startswith(begin))}"

    verbs = ("render", "long", "verify", "repair", "ids", "count")
    return (
        f"soak {source['seed']}, {source['variant']}",
        source["commit"][:7],
        f"{record['seconds']}",
        f"{tried['rounds']}",
        f"{sum(tried.get(f'commands: {verb}', 0) for verb in verbs)}",
        total("signals"),
        total("workers killed"),
        total("damages"),
        f"{tried['frames judged by verify']}",
        f"{sum(record['broken'].values())}",
    )


def _longest(soaks: Sequence[Mapping[str, Any]]) -> str:
    """Write how long the longest soak on record took, and whether one of an hour is there."""
    if not soaks:
        return "No soak is on record."
    minutes = max(each["seconds"] for each in soaks) / 60
    whole = "" if minutes >= 60 else "; none of an hour is on record"
    return f"The longest soak on record took {minutes:.0f} minutes{whole}."


def _fuzz(record: dict[str, Any]) -> str:
    cases = record["cases"]
    taken, refused = (
        sum(n for k, n in cases.items() if k.endswith(how)) for how in ("taken", "refused")
    )
    ended = _listed(
        f"{n:,} with {name.rpartition(' ')[2]}"
        for name, n in cases.items()
        if name.startswith("whole_programs")
    )
    programs = f" Whole programs: {ended} as exit code." if ended else ""
    return (
        f"The fuzzer, at {record['commit'][:7]}: {taken + refused:,} inputs judged, of which "
        f"{taken:,} were taken and {refused:,} refused with a rule and a cure; no other error came."
        f"{programs}"
    )


def _error(each: Mapping[str, float]) -> str:
    return f"{each['error']:.4f} ({each['low']:.4f} to {each['high']:.4f})"


def _interval(each: Mapping[str, float]) -> str:
    return f"{each['ratio']:.4f} ({each['low']:.4f} to {each['high']:.4f})"


def _origin(record: StudyRecord) -> str:
    made_by = record.provenance
    machine = f"{made_by['cores']} cores of {made_by['cpu']}"
    where = f"results/studies/{record.study}.json"
    return (
        f"`lodbench study {record.study} --record {where}`, {machine}, "
        f"{short_commits({made_by['commit']})}."
    )


def _listed(values: Any) -> str:
    words = [str(each) for each in values]
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


if __name__ == "__main__":
    for page in PAGES:
        path = ROOT / page
        path.write_text(filled(path.read_text(encoding="utf-8")), encoding="utf-8")
