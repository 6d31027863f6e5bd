"""Inference of the decisions that the thesis leaves open, from its own tables (docs/decisions.md)."""
