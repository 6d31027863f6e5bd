"""`khepera-forage arena`: list, draw and write arenas."""
