"""How bodies walk: patrols, paths of feet, errors at the ground."""
