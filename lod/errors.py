"""The error for bad input: one line with the rule, what arrived, and the cure."""


class InputError(ValueError):
    """A value that breaks a rule.

    ``where`` names the flag, key or argument; ``arrived`` is what was given; ``rule`` is what it
    must satisfy; ``cure`` is one thing that would work.
    """

    def __init__(self, where: str, arrived: object, rule: str, cure: str = "") -> None:
        self.where, self.arrived, self.rule, self.cure = where, arrived, rule, cure
        message = f"{where}: {_short(arrived)}: {rule}"
        super().__init__(shown(f"{message}; {cure}" if cure else message))

    def __reduce__(self) -> tuple[type, tuple[str, object, str, str]]:
        """Return what pickle needs to build the error again in another process."""
        return type(self), (self.where, self.arrived, self.rule, self.cure)


def shown(text: str) -> str:
    """Return text that a terminal shows and does not obey: control characters as escapes."""
    return "".join(c if c.isprintable() or c.isspace() else ascii(c)[1:-1] for c in text)


def _short(arrived: object, longest: int = 80) -> str:
    text = repr(arrived).replace("\n", " ")
    if len(text) <= longest:
        return text
    kept = longest // 2  # of either end: a path ends in the name of its file
    return f"{text[: kept - 1]}…{text[-kept:]}"
