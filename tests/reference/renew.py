"""`python tests/reference/renew.py [GROUP ...]`: writes the reference values anew.

Right after a change of results that is meant, once benchmarks have shown that it is for
the better, and in the same commit. Wrong to make a failing test pass: where no result was
to change, the test has found a mistake.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT)]

from reference.groups import GROUPS  # noqa: E402
from reference.kept import FOLDER, write_values  # noqa: E402

if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name in sys.argv[1:] or GROUPS:
        write_values(name, GROUPS[name])
