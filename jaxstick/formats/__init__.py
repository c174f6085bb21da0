"""Files to arrays and back: units, CSV tables, time axes, channels, rig.toml."""
