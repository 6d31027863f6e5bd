"""The comparison of all learners by `khepera-forage compare`."""

TRACKS = ("offline", "teaching", "wheels", "vocabulary")
"""Names of the protocol's tracks, for those who do not want to import what learns in them."""
