"""Write the figures that pages quote from records, between the marks of their blocks.

A block begins with ``<!-- figures: NAME -->`` and ends with ``<!-- end of figures -->``; what
stands between is written from records: those of studies, soaks and the fuzzer, and the claims of
the reference run that the report's first screen chooses. `make docs` fills all pages, and a test
compares. A block says so where its record is not there yet.
"""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from bench.records.claims import Claim
from bench.records.study_record import StudyRecord, read_study_record
from bench.report.first_screen import CHOSEN
from bench.report.words import MARKS, verdict_text
from bench.studies.acting import study as acting_study
from bench.studies.defocus import saved_share

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "results"
REFERENCE, STUDIES = RESULTS / "reference", RESULTS / "studies"
PAGES = (
    "README.md",
    "docs/depth-of-field.md",
    "docs/framing.md",
    "docs/promises.md",
    "results/acting.md",
    "results/cost.md",
)
_BLOCK = re.compile(r"(<!-- figures: (\w+) -->\n).*?(<!-- end of figures -->)", re.S)


def filled(text: str) -> str:
    """Give a page with the figures of all its blocks. Raises KeyError for an unknown block."""
    return _BLOCK.sub(lambda found: f"{found[1]}\n{_figures(found[2])}\n\n{found[3]}", text)


def claims() -> str:
    """Write the chosen claims of the reference run, a row each, and the commits they are of."""
    runs = json.loads((REFERENCE / "claims.json").read_text(encoding="utf-8"))
    found = {(run["experiment"], one["name"]): (run, one) for run in runs for one in run["claims"]}
    rows, commits = [], set()
    for run, one in (found[each] for each in CHOSEN if each in found):
        claim = Claim(**{key: value for key, value in one.items() if key != "verdict"})
        verdict = f"{MARKS[claim.verdict]} {verdict_text(claim)}"
        numbers = claim.claimed_text, claim.measured_text
        rows.append((claim.about, claim.quantity, *numbers, verdict, f"`run {run['experiment']}`"))
        commits.add(_commit(run))
    heads = "claim", "quantity", "claimed", "measured (95 %)", "verdict", "measured by"
    text = _table(heads, rows)
    return f"{text}\n\nMeasured at {_commits(commits)}; a row is missing where its claim is newer."


def start() -> str:
    """Write how long commands take from the shell to their answer."""
    record = _study("start")
    rows = []
    for name, each in record.figures.items():
        interval = f" ({each['low']:.2f} to {each['high']:.2f})" if each["low"] else ""
        seconds = (f"{each[key]:.2f}" for key in ("imports_s", "own_s", "command_s"))
        rows.append((name, *seconds, f"{each['ratio']:.2f}{interval}"))
    heads = "command", "imports [s]", "trace [s]", "command [s]", "command ÷ (imports + trace)"
    return f"{_table(heads, rows)}\n\n{_origin(record)}"


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
    return (
        f"{_table(heads, rows)}\n\n{record.settings['fields']} fields of people. {_origin(record)}"
    )


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
    return f"{_table(heads, rows)}\n\n{how} {of_law} {_origin(record)}"


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
    table = _table(heads, [_soak(each) for each in _records("soak")])
    return "\n\n".join((table, *(_fuzz(each) for each in _records("fuzz"))))


BLOCKS: Mapping[str, Callable[[], str]] = {
    "claims": claims,
    "start": start,
    "framing": framing,
    "defocus": defocus,
    "acting": acting,
    "tried": tried,
}


def _figures(block: str) -> str:
    try:
        return BLOCKS[block]()
    except FileNotFoundError as missing:
        return f"Not measured yet: there is no {Path(str(missing.filename)).relative_to(ROOT)}."


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
        f"{_commits({made_by['commit']})}."
    )


def _commit(run: Mapping[str, Any]) -> str:
    path = REFERENCE / f"{run['experiment']}-{run['record_sha256'][:16]}.json"
    content = json.loads(path.read_text(encoding="utf-8"))["content"]
    return str(content["provenance"]["commit"])


def _commits(commits: set[str]) -> str:
    names = sorted(f"{each[:7]}{' with changes' if '+' in each else ''}" for each in commits)
    return f"commit{'s' if len(names) > 1 else ''} {_listed(names)}"


def _listed(values: Any) -> str:
    words = [str(each) for each in values]
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(
        "| " + " | ".join(each.replace("|", "\\|") for each in line) + " |" for line in lines
    )


if __name__ == "__main__":
    for page in PAGES:
        path = ROOT / page
        path.write_text(filled(path.read_text(encoding="utf-8")), encoding="utf-8")
