"""Where robots live: arenas, and the worlds that move bodies in them."""
