"""The `khepera-forage` command: one module, or one folder, for each subcommand."""
