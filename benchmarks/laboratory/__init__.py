"""Parts of the script that measures the tracker: its frames, and what it finds in them."""
