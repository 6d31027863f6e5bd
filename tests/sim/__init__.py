"""Arenas, and bodies that move in them."""
