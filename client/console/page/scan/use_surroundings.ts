import { useEffect, useRef } from "preact/hooks";
import { Surroundings } from "./surroundings.ts";

/** The landmarks around a vehicle in a map's version, where that is known. */
export function useSurroundings(
  map: { server: string; name: string; version: number } | undefined,
  onTile: () => void,
): Surroundings | undefined {
  const made = useRef<Surroundings>();
  const { server, name, version } = map ?? {};
  useEffect(() => {
    if (!server || !name || !version) return undefined;
    made.current = new Surroundings(server, name, version, onTile);
    onTile();
    return () => {
      made.current?.close();
      made.current = undefined;
    };
  }, [server, name, version]);
  return made.current;
}
