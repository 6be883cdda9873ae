"""Flags and bytes: one file per verb; the only click, open and sys.exit."""
