"""Where and of what a benchmark was run."""

import platform
import subprocess


def provenance():
    """Machine and commit, for the line of JSON."""
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True).stdout.strip()
    return {"machine": platform.processor() or platform.machine(), "commit": commit}
