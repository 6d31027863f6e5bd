"""The comparison of all learners by `khepera-forage compare`."""

PROTOCOL = "forage-bench-1"
TRACKS = ("offline", "teaching", "wheels", "vocabulary")
"""Names of the protocol and its tracks, for those who do not want to import what learns in them."""
