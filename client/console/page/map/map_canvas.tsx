import { useEffect, useRef, useState } from "preact/hooks";
import { failureText } from "../parts/notice.tsx";
import { shortened } from "../texts/shortened.ts";
import { t } from "../texts/texts.ts";
import type { CallFailure } from "../wire/failure.ts";
import type { Bounds } from "./camera.ts";
import type { MapDrawn } from "./draw_map.ts";
import type { Loss, Vehicle } from "./fleet.ts";
import { type Overlay, Scene } from "./scene.ts";
import { TileStore } from "./tile_store.ts";

interface Props {
  /** The map to draw; undefined: the vehicles alone. */
  map: { server: string; name: string; version: number } | undefined;
  extent: Bounds | undefined;
  firstView?: Bounds | undefined;
  overlay?: Overlay | undefined;
  vehicles: () => Iterable<Vehicle>;
  losses?: readonly Loss[];
  chosen?: string | undefined;
  follow?: boolean;
  onChoose?: (vehicle: Vehicle | undefined) => void;
  onPlace?: ((x: number, y: number) => void) | undefined;
  onDrawn?: (drawn: MapDrawn) => void;
  /** Changes when there is something new to draw. */
  tick?: number;
}

const NO_LOSSES: readonly Loss[] = [];

/** A map with its vehicles, and buttons to move the view. */
export function MapCanvas(props: Props) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const scene = useRef<Scene>();
  const tiles = useRef<TileStore>();
  const [fault, setFault] = useState<CallFailure>();
  const { map, extent, vehicles, losses = NO_LOSSES, chosen, follow = false } = props;

  const content = () => ({
    tiles: tiles.current,
    extent,
    vehicles,
    losses,
    chosen,
    follow,
    ...(props.firstView ? { firstView: props.firstView } : {}),
    ...(props.overlay ? { overlay: props.overlay } : {}),
    ...(props.onChoose ? { onChoose: props.onChoose } : {}),
    ...(props.onPlace ? { onPlace: props.onPlace } : {}),
    ...(props.onDrawn ? { onDrawn: props.onDrawn } : {}),
  });

  useEffect(() => {
    const made = new Scene(canvas.current!, content());
    scene.current = made;
    return () => made.close();
  }, []);

  useEffect(() => {
    const onTile = (): void => {
      scene.current?.redrawMap();
      setFault(tiles.current?.fault);
    };
    const made = map && new TileStore(map.server, map.name, map.version, onTile);
    tiles.current = made;
    setFault(undefined);
    scene.current?.set(content());
    return () => made?.close();
  }, [map?.server, map?.name, map?.version]);

  useEffect(() => scene.current?.set(content()));

  return (
    <div class={props.onPlace ? "map placing" : "map"}>
      <canvas ref={canvas} tabIndex={0} role="application" aria-label={t("map_canvas")} />
      {fault && (
        <p class="map-fault fault small" role="status">
          {t("map_unreadable", { message: shortened(failureText(fault)) })}
        </p>
      )}
      <div class="map-buttons">
        <button onClick={() => scene.current?.zoom(1.6)} aria-label={t("zoom_in")} title={t("zoom_in")}>
          +
        </button>
        <button onClick={() => scene.current?.zoom(1 / 1.6)} aria-label={t("zoom_out")} title={t("zoom_out")}>
          −
        </button>
        <button onClick={() => scene.current?.fit()} aria-label={t("fit")} title={t("fit")}>
          ⤢
        </button>
      </div>
    </div>
  );
}
