"""`khepera-forage camera`: its subcommands, their window and their picture sources."""
