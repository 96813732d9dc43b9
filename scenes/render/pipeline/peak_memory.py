"""How much memory this process has held at most."""

import sys
from pathlib import Path


def peak_rss_bytes() -> int:
    """Most memory that this process has held [bytes]; 0 where the system does not say.

    On Linux ``ru_maxrss`` would start from what the process held that started it.
    """
    status = Path("/proc/self/status")
    if status.exists():
        rows = status.read_text(encoding="ascii", errors="replace").splitlines()
        held = [int(row.split()[1]) * 1024 for row in rows if row.startswith("VmHWM")]
        if held:
            return held[0]
    try:
        import resource
    except ImportError:
        return 0
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024
