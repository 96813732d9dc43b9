"""This package has the people: stick figures that stand and walk."""
