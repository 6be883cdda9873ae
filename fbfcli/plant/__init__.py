"""Frequency f: what the machine makes of a command."""
