"""Rooms whose variable is the line number: text to moves, and nodes to text."""
