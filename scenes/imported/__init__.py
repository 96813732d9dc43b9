"""This package reads models of other people, glTF and USD, and makes prototypes of them."""
