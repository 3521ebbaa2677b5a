"""Mutants of the source, and which tests notice them."""
