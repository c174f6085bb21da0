"""Tests of the structure of the source itself."""
