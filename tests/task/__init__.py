"""The task as pure functions."""
