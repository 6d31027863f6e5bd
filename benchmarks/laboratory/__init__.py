"""Parts of the scripts that measure the laboratory: what cameras see, how devices fail, and what is true."""
