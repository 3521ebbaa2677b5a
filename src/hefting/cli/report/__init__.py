"""Results as tables a person can read, with units: a file each kind."""
