"""Tests of the sealed cases."""
