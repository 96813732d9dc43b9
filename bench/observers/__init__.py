"""An experiment for people: pairs of pictures, a page that shows them, and the fit of answers."""
