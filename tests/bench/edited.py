"""Points with a column of samples changed, for tests of what follows from it."""

from dataclasses import replace


def edited(point, quantity, change, **keys):
    """The point with ``change`` made to the values of one column."""
    before = point.column(quantity, **keys)
    samples = tuple(
        replace(each, values=change(before)) if each.values is before else each
        for each in point.samples
    )
    return replace(point, samples=samples)
