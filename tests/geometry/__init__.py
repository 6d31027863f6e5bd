"""Angles, polygons and walls against brute force."""
