"""The upper commands, one file each."""
