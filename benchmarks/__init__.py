"""Speed and memory, each beside what one would use instead, in one run: `python -m
benchmarks`."""
