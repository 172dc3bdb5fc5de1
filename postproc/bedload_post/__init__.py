"""Reads the files of a run and shows what they hold; it starts nothing and changes no run."""
