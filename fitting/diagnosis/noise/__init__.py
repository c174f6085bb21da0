"""What no model is asked to explain: how far the records do not repeat themselves."""
