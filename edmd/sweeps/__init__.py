"""Many runs: a config or a function over grids, lists and draws of its parameters, in one directory, as a table (docs/sweeps.md)."""
