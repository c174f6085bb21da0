"""Tests of the diagnosis, its report and its files."""
