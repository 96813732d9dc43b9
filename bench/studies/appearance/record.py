"""What the study has found: kept as JSON, object by object, and written as a table."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.records.study_record import read_study_record, study_record, write_study_record
from bench.studies.appearance.cases import Case
from lod.errors import InputError
from scenes.appearance.fit import CODE
from scenes.processes.cache import ROOT, source_digest

MEAN_COVER, EACH_COVER, RADIANCE = 0.05, 0.15, 0.03
"""How far the mean cover, that from each direction, and the radiance may be from the whole's."""

BEGIN, END = "<!-- judged -->", "<!-- /judged -->"
"""Lines of a page between which the table stands."""

HEADER = "object", "level", "mean cover", "worst direction", "radiance, from … to", "within"


@dataclass(frozen=True)
class Judged:
    """One object displayed down to one level, over the whole of it.

    covers     ratio of the covered area in each of 64 directions
    radiances  ratio of the mean radiance for every sun and elevation of the eye; empty where no
               light was asked for
    """

    kind: str
    seed: int
    level: int
    covers: tuple[float, ...]
    radiances: tuple[float, ...]

    @property
    def mean(self) -> float:
        """Return the mean ratio of covers."""
        return float(np.mean(self.covers))

    @property
    def worst(self) -> float:
        """Return the ratio of covers that is farthest from 1."""
        return max(self.covers, key=lambda ratio: abs(ratio - 1))

    @property
    def within(self) -> bool:
        """Tell whether all that was measured is within the limits."""
        covers = abs(self.mean - 1) <= MEAN_COVER and abs(self.worst - 1) <= EACH_COVER
        return covers and all(abs(ratio - 1) <= RADIANCE for ratio in self.radiances)

    @property
    def cells(self) -> tuple[str, ...]:
        """Return the line of the table."""
        shines = self.radiances and f"{min(self.radiances):.3f} … {max(self.radiances):.3f}"
        names = Case(self.kind, self.seed).title, str(self.level)
        covers = f"{self.mean:.3f}", f"{self.worst:.3f}"
        return *names, *covers, shines or "", "yes" if self.within else "no"


def fit_digest() -> str:
    """Return a digest of the sources that fit appearances: findings of others are not these."""
    return source_digest([ROOT.joinpath(*name.split(".")) for name in CODE])


def read_findings(path: Path) -> list[Judged]:
    """Read what a file holds; nothing where there is none. Raises InputError for another file."""
    if not path.exists():
        return []
    try:
        return [_judged(each) for each in read_study_record(path).figures["judged"]]
    except (KeyError, TypeError) as error:
        rule = f"what this study has written ({error})"
        raise InputError("-o", str(path), rule, "name another folder") from None


def fit_of(path: Path) -> str:
    """Return the digest of the fit that a file's findings are of."""
    digest: str = read_study_record(path).settings["fit"]
    return digest


def write_findings(path: Path, found: Sequence[Judged], variant: str) -> None:
    """Write all findings with where they come from, whole or not at all."""
    figures = {"judged": [asdict(each) for each in found]}
    settings = {"fit": fit_digest()}
    write_study_record(path, study_record("appearance", settings, figures, variant))


def markdown(found: Iterable[Judged]) -> str:
    """Write findings as a table in Markdown."""
    rule = "|---" * len(HEADER) + "|"
    lines = ["| " + " | ".join(HEADER) + " |", rule]
    lines += ["| " + " | ".join(each.cells) + " |" for each in found]
    return "\n".join(lines) + "\n"


def with_table(page: str, found: Iterable[Judged]) -> str:
    """Put the table of findings between the marks of a page. Raises ValueError without them."""
    before, middle, rest = page.partition(f"{BEGIN}\n")
    _, end, after = rest.partition(f"{END}\n")
    if not middle or not end:
        raise ValueError(f"no line {BEGIN} before a line {END}")
    return f"{before}{BEGIN}\n{markdown(found)}{END}\n{after}"


def _judged(said: dict[str, Any]) -> Judged:
    covers, radiances = (tuple(said[name]) for name in ("covers", "radiances"))
    return Judged(said["kind"], said["seed"], said["level"], covers, radiances)
