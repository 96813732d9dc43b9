"""The experiment `eye`."""
