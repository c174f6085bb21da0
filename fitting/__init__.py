"""What records say about the rig: fits, intervals and comparisons."""
