"""Files of other programs, one room a format: `write(path, frames)` takes `edmd.trajectory.Frame`s, `read(path, frame, inertia)` gives a
System. What each keeps, and how exactly: docs/file_format.md. `edmd.exchange` is the way in."""
