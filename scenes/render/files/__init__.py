"""Frames, manifests and other files on disk."""
