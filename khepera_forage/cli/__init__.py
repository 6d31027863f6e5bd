"""The `khepera-forage` command: `main` parses arguments; each subcommand is a module with `add_arguments` and `run`."""
