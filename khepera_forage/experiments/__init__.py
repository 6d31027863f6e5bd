"""The thesis' training and recall experiments: their design, their rows, and what is concluded from them."""
