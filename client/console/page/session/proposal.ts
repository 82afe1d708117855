import type { MessageInitShape } from "@bufbuild/protobuf";
import type { PoseWithCovarianceSchema } from "proto/dcloc/v1/geometry_pb.ts";
import type { Overlay } from "../map/scene.ts";
import { drawBody } from "../map/draw_arrow.ts";
import { drawEllipse } from "../map/draw_vehicles.ts";

/** Where somebody thinks that the vehicle was at its last scan. */
export interface Proposal {
  x: number;
  y: number;
  /** Counter-clockwise from the map's x axis; undefined: any. */
  yawDeg: number | undefined;
  sigmaM: number;
  yawSigmaDeg: number;
}

/** What of it is chosen so far. */
export type ProposalDraft = { [Key in keyof Proposal]?: Proposal[Key] | undefined };

export const FIRST_PROPOSAL: ProposalDraft = { yawDeg: undefined, sigmaM: 5, yawSigmaDeg: 10 };
/** Whether a place was chosen, and all that goes with it is a number. */
export function isPlaced(proposal: ProposalDraft): proposal is Proposal {
  const { x, y, yawDeg, sigmaM, yawSigmaDeg } = proposal;
  return [x, y, yawDeg ?? 0, sigmaM, yawSigmaDeg].every(Number.isFinite);
}

/** A plan has no heights. */
const HEIGHT_SIGMA_M = 100;
/** A street is level but for so much. */
const TILT_SIGMA_RAD = (3 * Math.PI) / 180;
/** Of a heading that may be any. */
const ANY_YAW_VARIANCE = Math.PI ** 2 / 3;

const radians = (degrees: number): number => (degrees * Math.PI) / 180;

/** As PoseWithCovariance. */
export function poseOf({
  x,
  y,
  yawDeg,
  sigmaM,
  yawSigmaDeg,
}: Proposal): MessageInitShape<typeof PoseWithCovarianceSchema> {
  const half = radians(yawDeg ?? 0) / 2;
  const variances = [
    sigmaM ** 2,
    sigmaM ** 2,
    HEIGHT_SIGMA_M ** 2,
    TILT_SIGMA_RAD ** 2,
    TILT_SIGMA_RAD ** 2,
    yawDeg === undefined ? ANY_YAW_VARIANCE : radians(yawSigmaDeg) ** 2,
  ];
  return {
    pose: {
      translationM: { x, y, z: 0 },
      rotation: { w: Math.cos(half), x: 0, y: 0, z: Math.sin(half) },
    },
    covariance: Array.from({ length: 36 }, (_, i) => (i % 7 === 0 ? variances[i / 7]! : 0)),
  };
}

/** Draws its ellipse, and an arrow where it has a heading. */
export function drawProposal({ x, y, yawDeg, sigmaM }: Proposal): Overlay {
  const variance = sigmaM ** 2;
  const pose = { x, y, yaw: radians(yawDeg ?? 0), xx: variance, xy: 0, yy: variance };
  return (context, camera, palette) => {
    drawEllipse(context, camera, pose, palette.ink);
    if (yawDeg !== undefined) return drawBody(context, camera, pose, palette.ink, palette.halo);
    context.beginPath();
    context.arc(camera.toScreenX(x), camera.toScreenY(y), 4, 0, 2 * Math.PI);
    context.fillStyle = palette.ink;
    context.fill();
  };
}
