"""The replaceable parts of an oscillator: rig, guide, drive, friction, contact, instrument."""
