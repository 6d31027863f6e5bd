"""The driver of real Kheperas: serial port, protocol, reply matching, session, fleet and emergency stop."""
