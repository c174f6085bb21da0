"""The rig of 1987 as the beginning of a rig file, for tests of what takes one."""

from __future__ import annotations

RIG = """\
[rig]
mass_kg = 2.38
stiffness_n_per_m = 1986.0
log_decrement = 0.207
[assumed]
A_n = 1.05
B_s_per_m = 100.0
C_n = 6.42
D_n_s_per_m = 0.002
k1_n_per_m = 99300.0
"""
