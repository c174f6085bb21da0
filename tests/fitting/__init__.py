"""Tests of the upper package: fits and comparisons."""
