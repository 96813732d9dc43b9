"""The experiment `cost`."""
