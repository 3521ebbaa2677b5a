"""Torques: joint torques in place of a wrench: runs, loaded and empty, folded to equations of the payload."""
