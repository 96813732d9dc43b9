"""Records of measurements, their claims and provenance."""
