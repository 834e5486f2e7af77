"""The table of a polynomial element: (ROWS, WIDTH), rows 0…5 the coefficients of the axes, row 6 those of u(σ) (`polynomials`).

Apart from the kernels, so that who only carries tables does not load them.
"""

from __future__ import annotations

DEGREE = 5
TERMS = DEGREE + 1
WIDTH = 8  # axes of a table, and coefficients of u(σ)
MAP = TERMS  # the row of u(σ)
ROWS = TERMS + 1
