"""The e-puck2 of GCtronic: its commands, its driver on a serial line, and a virtual one."""
