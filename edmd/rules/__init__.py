"""Collision rules: contact in, impulse out."""
