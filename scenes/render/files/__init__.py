"""This package reads and writes frames, manifests and other files."""
