"""Arenas by name: the thesis's, a family of further ones, and levels that a generator draws."""
