import { useEffect, useRef, useState } from "preact/hooks";
import { Fleet } from "../map/fleet.ts";
import { type Link, followFleet } from "./live_stream.ts";

export interface FleetLink {
  fleet: Fleet;
  link: Link;
  /** Grows with each frame. */
  tick: number;
}

/** The fleet, followed while the page is open; whoever uses it is shown again with each frame. */
export function useFleet(): FleetLink {
  const fleet = useRef(new Fleet());
  const [link, setLink] = useState<Link>("connecting");
  const [tick, setTick] = useState(0);
  useEffect(
    () =>
      followFleet((frame) => {
        fleet.current.take(frame, performance.now());
        setTick((n) => n + 1);
      }, setLink),
    [],
  );
  return { fleet: fleet.current, link, tick };
}
