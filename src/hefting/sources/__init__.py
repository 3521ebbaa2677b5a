"""Sources: where the samples of a live stream come from: one file a transport, one
list (`hefting.sources.registry`)."""
