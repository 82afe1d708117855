/** What the bridge tells the page of the fleet: lines of JSON, one frame a line. An
 * empty line says only that the bridge is there. */

/** A session as the live view shows it. Lengths in metres, angles in radians, in the map's frame. */
export interface LiveSession {
  id: string;
  vehicle: string;
  map: string;
  version: number;
  /** LocalizationState of the contract. */
  state: number;
  /** It has no stream and waits for its vehicle. */
  detached: boolean;
  /** Seconds without a scan, in steps of 5; 0 below 5. */
  silentS: number;
  /** Absent while no pose is known, or the server does not tell it in its list. */
  pose?: LivePose;
  /** Sources that are set aside or have a fault, by name. */
  faults: string[];
  /** Which server of its fleet has it; absent for a server by itself. */
  replica?: string;
}

/** A place where a vehicle got lost, in the map's frame. */
export interface LiveLoss {
  vehicle: string;
  map: string;
  x: number;
  y: number;
  /** Before the frame was written. */
  agoMs: number;
}

/** A server of the fleet that did not answer; what is shown of its sessions is old. */
export interface SilentReplica {
  address: string;
  fault: string;
}

export interface LivePose {
  x: number;
  y: number;
  yaw: number;
  /** Covariance of x and y, m^2. */
  xx: number;
  xy: number;
  yy: number;
  /** On the vehicle's clock. */
  stampMs: number;
}

/** What one server says. A `full` frame replaces all that was known of it, losses as well. */
export interface LiveFrame {
  server: string;
  full?: boolean;
  set?: LiveSession[];
  gone?: string[];
  /** New ones; of the last hour in a `full` frame. */
  losses?: LiveLoss[];
  /** Absent where all have answered. */
  silent?: SilentReplica[];
  /** The server did not answer; what is known of it is old. */
  failure?: { code: number; message: string };
}

/** The kinds of a stream's frames: a byte, the payload's length in four, the payload. */
export const enum FrameKind {
  /** A message of the server's stream, as it came. */
  Message = 0,
  /** JSON, StreamEnd: nothing follows. */
  End = 1,
  /** JSON, a number: messages that this page was too slow for, so far. */
  Missed = 2,
}

export interface StreamEnd {
  /** A gRPC status code; 0: the session ended. */
  code: number;
  message: string;
}

export const FRAME_HEADER_BYTES = 5;
