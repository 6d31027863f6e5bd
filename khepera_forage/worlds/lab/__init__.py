"""What a laboratory is made of: its file, its devices, its beat, and the person who puts things in place."""
