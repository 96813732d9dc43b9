"""How objects walk: gaits, paths of feet, patrols, errors of feet against the ground."""
