"""Client of dcloc, the radar localization service. The messages are in `dcloc.v1`."""

from dcloc.channel import connect
from dcloc.session import Session

__all__ = ["Session", "connect"]
