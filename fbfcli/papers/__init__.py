"""The papers' tables and figures, recomputed by this package's own code; one module per paper or chapter."""
