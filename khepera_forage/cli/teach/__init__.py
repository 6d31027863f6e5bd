"""`khepera-forage teach`: a person is the teacher, with keys in a window (4.5)."""
