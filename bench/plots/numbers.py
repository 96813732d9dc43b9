"""How are numbers written in captions, tables and reports?"""


def four_decimals(value: float) -> str:
    """Write a number with four decimals, a true minus sign, and no sign before zero."""
    return f"{round(value, 4) + 0.0:.4f}".replace("-", "−")


def plain_number(value: float) -> str:
    """Write a number with as many digits as it needs, six at most, and a true minus sign."""
    return f"{value:g}".replace("-", "−")
