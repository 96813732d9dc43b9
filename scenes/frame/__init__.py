"""From a world and a view to the input of a renderer."""
