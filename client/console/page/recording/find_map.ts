import type { RecordingHeader } from "proto/dcloc/v1/recording_pb.ts";
import { MapService, type MapVersion } from "proto/dcloc/v1/map_service_pb.ts";
import { type ServerName, call } from "../wire/calls.ts";

export interface FoundMap {
  server: string;
  version: MapVersion;
  /** By the file's hash; without one it is only of the same name and number. */
  isCertain: boolean;
}

/**
 * The version that a recording was made in, on one of the servers: the one with its hash. Where the
 * recording tells none, that of the same name and number. `first` is asked first.
 */
export async function findMap(
  servers: readonly ServerName[],
  first: string | undefined,
  { opened, mapSha256 }: RecordingHeader,
  signal: AbortSignal,
): Promise<FoundMap | undefined> {
  const mapName = opened?.mapName ?? "";
  const number = opened?.mapVersion ?? 0n;
  const names = servers.map(({ name }) => name).sort((a, b) => Number(b === first) - Number(a === first));
  for (const server of names) {
    try {
      const request = { mapName, pageSize: 1000 };
      const answer = await call(server, MapService.method.listMapVersions, request, signal);
      const version = answer.versions.find((v) =>
        mapSha256 ? v.sha256 === mapSha256 : v.version === number,
      );
      if (version) return { server, version, isCertain: mapSha256 !== "" };
    } catch {
      signal.throwIfAborted();
      // Another server may have it.
    }
  }
  return undefined;
}
