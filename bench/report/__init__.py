"""The report of a folder of records."""
