"""Metrics and representations of other installed packages."""
