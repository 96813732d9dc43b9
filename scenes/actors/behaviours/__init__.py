"""This package has the behaviours that come with the program, and finds those of other packages."""
