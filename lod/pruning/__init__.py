"""From a view and a representation to the cut: the parts that are displayed."""
