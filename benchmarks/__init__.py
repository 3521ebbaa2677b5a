"""Speed and memory of the estimators, each beside what one would use instead, in one run: `python -m benchmarks`."""
