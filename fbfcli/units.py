"""Conversion factors, used once, at the door. Inside: mm, s, Hz, kg, N."""

S_PER_MIN = 60.0
MM_PER_INCH = 25.4
MM_PER_UM = 1e-3
MM_S2_PER_G = 9806.65
