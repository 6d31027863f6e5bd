"""`khepera-forage robot`: its subcommands, for a robot at a serial port."""
