"""The numbers that the second table of robustness.py is held against [um].

They are another prototype's: the same formulas on five other parts, contour error RMS, geometric mean over the parts at
5,000 and 15,000 mm/s^2, exact and at frequencies +-5, +-10, +-15 % off, dampings half and twice. Which parts, how they
were printed, and how the two signs of an error make one number is not said: robustness_parts.py asks the numbers.
"""

from __future__ import annotations

REFERENCE = {
    "35/28 Hz": {"none": (178, 188, 200, 222, 251, 127), "zv": (7.7, 18, 34, 55, 15, 12),
                 "mzv": (20, 23, 31, 44, 22, 21), "ei": (51, 52, 51, 51, 53, 51), "lpfbs": (4.5, 20, 41, 66, 15, 12),
                 "robust ±15 %": (18, 20, 27, 41, 25, 17),
                 "contour ±15 %": (11, 13, 18, 29, 15, 11), "contour ±10 %": (8.6, 11.5, 21, 39, 13, 9.4)},
    "45/36 Hz": {"zv": (4.8, 10, 19, 29, 8, 7), "mzv": (12, 14, 18, 24, 13, 13), "lpfbs": (2.8, 11, 22, 35, 8, 6),
                 "contour ±15 %": (6.0, 7.4, 10.9, 16.9, 8.2, 6.1)},
    "45+85/38+66 Hz": {"zv": (10, 12, 16, 21, 13, 10), "mzv": (14, 15, 17, 20, 15, 15),
                       "lpfbs": (3.3, 10, 20, 31, 8, 7), "contour ±15 %": (5.5, 6.5, 9.2, 13.8, 7.7, 5.4)},
    "taz6 x/hictop x": {"zv": (33, 35, 41, 49, 47, 67), "mzv": (27, 29, 35, 43, 42, 66), "ei": (27, 29, 34, 42, 41, 66),
                        "lpfbs": (6.9, 15, 28, 40, 34, 62), "contour ±15 %": (9.4, 12.3, 18.5, 27, 28, 61)},
    "70/56 Hz": {"zv": (2.2, 4.0, 7.1, 10.9, 3.2, 2.9), "mzv": (5.3, 5.9, 7.3, 9.7, 5.5, 5.5),
                 "lpfbs": (1.3, 4.3, 8.2, 12.9, 3.2, 2.6), "contour ±15 %": (2.4, 3.1, 4.5, 6.8, 3.1, 2.5)},
}  # fmt: skip
