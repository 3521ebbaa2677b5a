"""Changes of the object within a recording: picked up, put down, swapped, slipped,
touched."""
