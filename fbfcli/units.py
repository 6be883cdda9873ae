"""Conversion factors, used once, at the door. Inside: mm, s, Hz, kg, N."""

S_PER_MIN = 60.0
MM_PER_INCH = 25.4
GRAVITY = 9806.65  # mm/s^2 in one g, standard
NS_PER_S = 1e9
UM_PER_MM = 1e3  # for people
