"""The compiled loops over strokes: where they lie, what is counted, surfaces in strips and zones."""
