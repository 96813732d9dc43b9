"""Write the figures that pages quote from records, between the marks of their blocks.

A block begins with ``<!-- figures: NAME -->`` and ends with ``<!-- end of figures -->``; what
stands between is written from a record: those of studies in results/studies, and the claims of the
reference run that the report's first screen chooses. `make docs` fills all pages, and a test
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
from bench.studies.defocus import saved_share

ROOT = Path(__file__).parents[1]
REFERENCE, STUDIES = ROOT / "results" / "reference", ROOT / "results" / "studies"
PAGES = ("README.md", "docs/depth-of-field.md", "docs/framing.md", "results/cost.md")
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


BLOCKS: Mapping[str, Callable[[], str]] = {
    "claims": claims,
    "start": start,
    "framing": framing,
    "defocus": defocus,
}


def _figures(block: str) -> str:
    try:
        return BLOCKS[block]()
    except FileNotFoundError as missing:
        return f"Not measured yet: there is no {Path(str(missing.filename)).relative_to(ROOT)}."


def _study(name: str) -> StudyRecord:
    return read_study_record(STUDIES / f"{name}.json")


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
