"""Simulated bodies: arenas, the World contract, and two backends: `pymunk` and `compiled`."""
