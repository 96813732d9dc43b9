"""Frozen workloads for other programs: a world as files, with a reference and its noise."""
