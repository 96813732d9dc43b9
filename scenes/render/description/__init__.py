"""From what is displayed to a plain scene description."""
