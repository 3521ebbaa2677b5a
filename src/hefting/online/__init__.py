"""One live pipeline for any source: raw samples in, an estimate at any time."""
