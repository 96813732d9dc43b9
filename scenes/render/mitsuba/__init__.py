"""From a scene description to Mitsuba's objects."""
