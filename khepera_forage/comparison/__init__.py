"""The comparison of all learners by `khepera-forage compare`."""
