"""Virtual Kheperas: the firmware in front of any robot, behind a pseudo-terminal or TCP port, with line faults."""
