"""The shelf: one candidate effect per file, found by listing this folder."""
