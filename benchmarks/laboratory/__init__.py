"""Parts of the scripts that measure the laboratory: what cameras see, how robots fail, and what is true."""
