"""Airlight and transmittance along each ray."""
