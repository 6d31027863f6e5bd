"""One suite a contract, to be run against every class that makes it: subclass and give a fixture."""
