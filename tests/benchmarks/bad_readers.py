"""What a bad reader of a file would do to the process that reads it: small, as each
process that dies is followed by one that imports this anew."""

import os
import time


def behave(name, seeds, seed, index, folder, place):
    """A stand-in for `run_case` that hangs, dies or takes memory at some numbers."""
    if index == 1:
        time.sleep(60.0)
    while index == 6:
        pass
    if index == 3:
        os._exit(7)
    if index == 5:
        bytes(2**32)  # 4 GiB
    return 0, "", ""


def bounded(*job):
    """The same; memory that is not there is said."""
    try:
        return behave(*job)
    except MemoryError:
        return 1, "memory", ""
