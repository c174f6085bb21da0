"""The diagnosis: where simulation and records part, which effect causes it, how far the gap closes."""
