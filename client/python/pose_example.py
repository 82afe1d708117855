"""A scan to a server, then the pose 100 times a second: pose_example.py HOST:PORT MAP"""

import sys
import time

import dcloc

front = dcloc.Radar("front", translation_m=(3.5, 0.0, 0.5))
with dcloc.VehicleSession(sys.argv[1], sys.argv[2], "example", [front]) as session:
    session.send_scan("front", sequence_number=0, stamp_ns=time.time_ns())  # with its targets
    print(session.next_answer().pose)
    for _ in range(10):
        session.add_ego_velocity(time.time_ns(), velocity=(20, 0, 0, 0, 0, 0))  # of the wheels
        try:
            print(session.smooth_pose_at(time.time_ns()))
        except dcloc.Error as error:
            print(error.status.name, error)  # no pose yet
        time.sleep(0.01)
