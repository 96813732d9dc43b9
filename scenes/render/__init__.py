"""This package turns a cut into pixels: description → Mitsuba → layers → EXR → sequence."""
