"""Plane geometry: angles, polygons and walls. Plain functions, called from Python and compiled."""
