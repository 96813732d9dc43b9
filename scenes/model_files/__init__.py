"""Models described by data files: which there are, and how a file is read and checked."""
