"""Core: the values that flow from one part to the next, and what every part needs."""
