"""Claims in the form of before claims were data: gone once every experiment states rows."""

from dataclasses import replace

from bench.records.claims import EXACT, Claim, at_most, within
from bench.records.claims import claim as row
from bench.statistics.estimates import Estimate


def claim(
    name: str,
    words: tuple[str, str, str],
    predicted: float,
    tolerance: float,
    measured: Estimate,
    relation: str = "equals",
    expected_to_fail: bool = False,
) -> Claim:
    """Make a claim from a name and words."""
    about, quantity, source = words
    bound = (
        at_most(predicted + tolerance) if relation == "at most" else within(predicted, tolerance)
    )
    unit = EXACT if measured.low == measured.high else "field"
    condition = {"about": about, "name": name}
    return row(
        quantity,
        bound,
        condition,
        measured,
        unit=unit,
        source=source,
        violation_expected=expected_to_fail,
    )


def verification(made: Claim) -> Claim:
    """Return the claim as a verification."""
    return replace(made, kind="verification")
