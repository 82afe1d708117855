import { useEffect, useRef, useState } from "preact/hooks";
import type { Bounds } from "../map/camera.ts";
import { around } from "../map/extent.ts";
import { Fleet, State, type Vehicle } from "../map/fleet.ts";
import { MapCanvas } from "../map/map_canvas.tsx";
import type { Overlay } from "../map/scene.ts";
import { type DrawnTarget, drawTargets } from "../scan/draw_scan.ts";
import type { LiveScans } from "../scan/live_scans.ts";
import { TRAIL_MS, sampleVehicle } from "../scan/sample_vehicle.ts";
import { ScanLegend } from "../scan/scan_legend.tsx";
import { useSurroundings } from "../scan/use_surroundings.ts";
import { count, t } from "../texts/texts.ts";
import type { History, Sample } from "./history.ts";

/** Half of the square that is shown around the vehicle at first. */
const FIRST_VIEW_M = 60;

interface Props {
  server: string;
  id: string;
  map: { server: string; name: string; version: number } | undefined;
  extent: Bounds | undefined;
  history: History;
  scans: LiveScans;
  /** As the list of sessions knows it; undefined: not yet. */
  vehicle: Vehicle | undefined;
  overlay: Overlay | undefined;
  /** A click means this place; the view stays where it is meanwhile. */
  onPlace: ((x: number, y: number) => void) | undefined;
}

/** Shows again with each frame of the screen for which an answer has come. */
function useAnswers(history: History): () => void {
  const [, setFrame] = useState(0);
  const show = (): void => setFrame((n) => n + 1);
  useEffect(() => {
    let shown: Sample | undefined;
    let request = 0;
    const pass = (): void => {
      if (history.last !== shown) show();
      shown = history.last;
      request = requestAnimationFrame(pass);
    };
    request = requestAnimationFrame(pass);
    return () => cancelAnimationFrame(request);
  }, [history]);
  return show;
}

/** Where its newest answer put it; until one comes, where the list of sessions has it. */
function shownVehicle({ server, id, history, vehicle }: Props): Vehicle | undefined {
  const { last } = history;
  if (!last) return vehicle;
  const way = history.samplesSince(last.timeMs - TRAIL_MS);
  const { vehicle: name = "", detached = false } = vehicle ?? {};
  return { ...sampleVehicle(last, way, { server, id, vehicle: name }), detached };
}

function Counts({ targets }: { targets: readonly DrawnTarget[] }) {
  const near = targets.filter(({ isNear }) => isNear).length;
  return <p>{t("scan_counts", { near: count(near), all: count(targets.length) })}</p>;
}

/** A running session on its map: the vehicle, and the newest scan of each radar. */
export function SessionMap(props: Props) {
  const { server, id, map, extent, history, scans, overlay, onPlace } = props;
  const show = useAnswers(history);
  const surroundings = useSurroundings(map, show);
  const [follow, setFollow] = useState(true);
  const first = useRef<Bounds>();
  const { last } = history;
  if (last && last.state !== State.Initializing) {
    first.current ??= around(last.x, last.y, FIRST_VIEW_M);
    surroundings?.moveTo(last.x, last.y);
  }
  const targets = scans.targetsAt(performance.now(), surroundings);
  const draw: Overlay = (context, camera, palette) => {
    drawTargets(context, camera, palette, targets);
    overlay?.(context, camera, palette);
  };
  return (
    <>
      <div class="session-map">
        <MapCanvas
          map={map}
          extent={extent}
          firstView={first.current}
          vehicles={() => {
            const vehicle = shownVehicle(props);
            return vehicle ? [vehicle] : [];
          }}
          chosen={Fleet.key(server, id)}
          overlay={draw}
          onPlace={onPlace}
          follow={follow && !onPlace && first.current !== undefined}
        />
        <label class="chip">
          <input type="checkbox" checked={follow} onChange={(e) => setFollow(e.currentTarget.checked)} />
          {t("follow")}
        </label>
      </div>
      <section aria-label={t("scans")}>
        <h2>{t("scans")}</h2>
        {scans.areMissing ? <p class="hint">{t("scans_not_told")}</p> : <Counts targets={targets} />}
        {!scans.areMissing && <ScanLegend />}
      </section>
    </>
  );
}
