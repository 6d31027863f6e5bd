"""The nearest-neighbour index of section 4.6: its distance, its memories, its votes."""
