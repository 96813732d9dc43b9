"""How a cut becomes pixels: plain description → Mitsuba → layers → EXR → sequence."""
