"""Counts of frames that are pruned and not rendered."""
