"""The tests of jaxstick and fitting."""
