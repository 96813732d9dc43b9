"""This package finds metrics and representations that other installed packages bring."""
