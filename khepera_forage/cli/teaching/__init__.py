"""A person in the teacher's place: what the keys say (`keys`), who decides (`person`), and the window (`window`)."""
