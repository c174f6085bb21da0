"""The lower commands, one file each."""
