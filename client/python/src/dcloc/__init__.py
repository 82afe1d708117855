"""Client of dcloc, the radar localization service. The messages are in `dcloc.v1`."""

from dcloc.channel import connect
from dcloc.library import Error, Status
from dcloc.session import Session
from dcloc.vehicle_session import Answer, Pose, Prior, Radar, State, VehicleSession

__all__ = ["Answer", "Error", "Pose", "Prior", "Radar", "Session", "State", "Status",
           "VehicleSession", "connect"]
