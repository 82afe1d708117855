"""Scans and ticks to a server, the pose 100 times a second: pose_example.py HOST:PORT MAP"""

import sys
import time

import dcloc

front = dcloc.Radar("front", translation_m=(3.5, 0.0, 0.5))
with dcloc.VehicleSession(*sys.argv[1:3], "example", [front], forget_answers=True) as session:
    for i in range(100):
        now_ns = time.time_ns()
        if i % 5 == 0:
            session.send_scan("front", i, now_ns)  # with its targets, as the radar measures
        session.add_motion(now_ns, speed_mps=20.0, yaw_rate_radps=0.0)
        try:
            print(session.smooth_pose_at(now_ns))
        except dcloc.Error as error:
            print("no pose yet:", error)
        time.sleep(0.01)
