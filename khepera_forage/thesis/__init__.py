"""The design, tables and claims of the thesis, and the report that compares our results with them."""
