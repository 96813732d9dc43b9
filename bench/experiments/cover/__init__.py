"""The experiment `cover`."""
