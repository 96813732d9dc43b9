"""The light of sun and sky as tables and vectors, for light that is followed without a renderer."""
