"""Tests of the lower package: physics, simulation, records."""
