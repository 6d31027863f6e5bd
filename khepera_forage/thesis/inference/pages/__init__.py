"""The pages of `khepera-forage infer`, one for each question."""
