"""Simulated bodies: arenas, the World contract, and two backends: `pymunk` and `compiled`.

A round is `advance` in `compiled/world.py`, and `_advance` in `pymunk/world.py`. What robots sense (`Senses` in
`robots.khepera`) is written in `sensing.py`, for both.
"""
