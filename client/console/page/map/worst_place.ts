import type { Loss } from "./fleet.ts";

/** Each is compared with those around it. */
const MAX_COUNT = 500;

/** Losses by the square of `side` metres that they lie in, each map for itself. */
function bySquare(losses: readonly Loss[], side: number): (loss: Loss) => Loss[] {
  const squares = new Map<string, Loss[]>();
  const keyOf = ({ map, x, y }: Loss, right = 0, up = 0): string =>
    `${Math.floor(x / side) + right}/${Math.floor(y / side) + up}/${map}`;
  for (const loss of losses) {
    const square = squares.get(keyOf(loss));
    if (square) square.push(loss);
    else squares.set(keyOf(loss), [loss]);
  }
  const steps = [-1, 0, 1];
  return (loss) => steps.flatMap((up) => steps.flatMap((right) => squares.get(keyOf(loss, right, up)) ?? []));
}

/** The most vehicles that got lost within `radiusM` of one another since `sinceMs`, and where. */
export function worstPlace(
  losses: readonly Loss[],
  radiusM: number,
  sinceMs: number,
): { count: number; x: number; y: number } | undefined {
  const recent = losses.filter((loss) => loss.timeMs >= sinceMs).slice(-MAX_COUNT);
  const around = bySquare(recent, radiusM);
  let worst: { count: number; x: number; y: number } | undefined;
  for (const loss of recent) {
    const { x, y } = loss;
    const near = around(loss).filter((l) => Math.hypot(l.x - x, l.y - y) <= radiusM);
    const vehicles = new Set(near.map(({ vehicle }) => vehicle)).size;
    if (vehicles > (worst?.count ?? 1)) worst = { count: vehicles, x, y };
  }
  return worst;
}
