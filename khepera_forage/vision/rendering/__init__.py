"""Synthetic frames of the overhead camera, and the markers to print."""
