"""The rules of the task."""
