"""Rigid bodies on pymunk: the backend `"pymunk"`."""
