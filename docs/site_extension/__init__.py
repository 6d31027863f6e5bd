"""Sphinx extension of this site: the API reference, parts generated from the package, and links to source files."""
