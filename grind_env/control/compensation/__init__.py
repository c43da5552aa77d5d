"""Dresser and wheel radius compensation, G40 to G42 (chapter 15)."""
