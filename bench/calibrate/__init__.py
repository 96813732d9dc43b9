"""Commands that measure tables of the scenes and write them to their data files."""
