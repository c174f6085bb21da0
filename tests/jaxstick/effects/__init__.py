"""Physics of the effects on the shelf, each against a closed form or an independent computation."""
