"""The other end of the line: a virtual Khepera's ports, their faults, and what its ROM keeps."""
