"""Write the figures of docs/promises.md from the records that soaks and the fuzzer leave."""

import json
from pathlib import Path
from typing import Any

PAGE = Path(__file__).parent / "promises.md"
RESULTS = Path(__file__).parents[1] / "results"

_BEGIN, _END = "<!-- what was tried -->\n", "<!-- as far as records tell -->\n"
_ENDS = ("taken", "refused")
_HEAD = (
    "what",
    "commit",
    "seconds",
    "rounds",
    "commands",
    "signals",
    "workers killed",
    "damages",
    "verdicts",
    "broken",
)


def page() -> str:
    """Write the page anew: what stands between its two marks comes from the records."""
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(_BEGIN)
    _, _, after = rest.partition(_END)
    return f"{before}{_BEGIN}{figures()}{_END}{after}"


def figures() -> str:
    """Write a row for each soak on record, and a sentence for each run of the fuzzer."""
    soaks = [_soak(each) for each in _records("soak")]
    lines = [_HEAD, ("---",) * len(_HEAD), *soaks]
    table = "".join(f"| {' | '.join(line)} |\n" for line in lines)
    return table + "".join(f"\n{_fuzz(each)}\n" for each in _records("fuzz"))


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
    taken, refused = (sum(n for k, n in cases.items() if k.endswith(how)) for how in _ENDS)
    return (
        f"The fuzzer, at {record['commit'][:7]}: {taken + refused:,} inputs judged, of which "
        f"{taken:,} were\ntaken and {refused:,} refused with a rule and a cure; no other error "
        "came."
    )


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
