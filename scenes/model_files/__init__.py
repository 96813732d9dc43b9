"""This package lists the models that presets can name, and reads the files of parameters."""
