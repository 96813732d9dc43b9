"""The experiment `updates`."""
