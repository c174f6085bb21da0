"""Records cut into lanes, and the compiled model that simulates them all with any effects attached."""
