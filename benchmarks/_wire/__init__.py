"""What `wire.py` is made of."""
