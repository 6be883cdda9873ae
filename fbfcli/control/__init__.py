"""Control point i: compensators. They get arrays, never a Plant or a Printer."""
