"""Collision rules: contact in, impulse out. One file a rule; `kinds.py` holds what they share and who is asked."""
