"""Sealed cases: records whose effect is withheld, made by a simulation of their own."""
