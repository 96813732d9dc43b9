"""Does the law hold, and what does it cost?

cases → measurements → records → fits → report, and the command line over them. An experiment is
a frozen grid of cases; what it measured is kept raw in an immutable record; claims are judged from
the record in one place; the report only shows what the records say.
"""
