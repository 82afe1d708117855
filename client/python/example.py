"""One scan to a server, its pose back: example.py HOST:PORT MAP"""

import sys

import dcloc
from dcloc.v1 import localization_service_pb2, scan_pb2

open_session = localization_service_pb2.OpenSession(vehicle_id="example", map_name=sys.argv[2])
radar = open_session.rig.radars.add(radar_id="front")
radar.t_vehicle_radar.translation_m.x = 3.5
radar.t_vehicle_radar.rotation.w = 1.0
with dcloc.Session(dcloc.connect(sys.argv[1]), open_session) as session:
    print(session.localize(scan_pb2.Scan(radar_id="front", stamp_ns=1_700_000_000_000_000_000)))
