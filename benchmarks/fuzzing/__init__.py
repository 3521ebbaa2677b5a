"""Mutated files of every kind that a command reads, and what the commands make of
them."""
