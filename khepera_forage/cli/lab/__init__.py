"""`khepera-forage lab`: its subcommands, for a laboratory with real robots."""
