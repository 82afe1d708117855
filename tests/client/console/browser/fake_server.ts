import * as grpc from "@grpc/grpc-js";
import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import {
  ListReplicasResponseSchema,
  ListSessionsResponseSchema,
  type Replica,
  type ReplicaFault,
  type Session,
  SessionSchema,
} from "proto/dcloc/v1/admin_service_pb.ts";
import {
  CancelMapBuildRequestSchema,
  CancelMapBuildResponseSchema,
  GetMapVersionResponseSchema,
  ListMapBuildsResponseSchema,
  ListMapsResponseSchema,
  type MapBuild,
  MapBuildState,
  type MapVersion,
  ReadMapTileRequestSchema,
  type ReadMapTileRequest,
  type ReadMapTileResponse,
  ReadMapTileResponseSchema,
} from "proto/dcloc/v1/map_service_pb.ts";

/** A map as the server serves it. */
export interface FakeMap {
  version: MapVersion;
  readTile(request: ReadMapTileRequest): ReadMapTileResponse;
}

const asIs = (bytes: Buffer): Buffer => bytes;

function unary(path: string) {
  return {
    path,
    requestStream: false,
    responseStream: false,
    requestSerialize: asIs,
    requestDeserialize: asIs,
    responseSerialize: asIs,
    responseDeserialize: asIs,
  };
}

/** What `answer` gives; what it throws is the failure of the call. */
function answered(answer: () => Uint8Array): [Partial<grpc.StatusObject> | null, Buffer?] {
  try {
    return [null, Buffer.from(answer())];
  } catch (error) {
    return [{ code: grpc.status.DATA_LOSS, details: (error as Error).message }];
  }
}

/** An answer with a field that this version of the contract does not have: number 4000, a text. */
function asOfNewer(bytes: Uint8Array): Buffer {
  const text = Buffer.from("news");
  return Buffer.concat([bytes, Buffer.from([0x82, 0xfa, 0x01, text.length]), text]);
}

/** A server that lists any sessions at all: as many, and as strange, as no real one would. */
export class FakeServer {
  sessions: Session[] = [];
  /** None: the server is so old that it does not know the calls. */
  map: FakeMap | undefined;
  listCount = 0;
  /** Servers of its fleet that did not answer it. */
  unanswered: ReplicaFault[] = [];
  /** None: it does not know the call. */
  replicas: Replica[] | undefined;
  builds: MapBuild[] = [];
  private readonly server = new grpc.Server();

  async start(): Promise<string> {
    const asked = (done: grpc.sendUnaryData<Buffer>, answer: (map: FakeMap) => Uint8Array) =>
      this.map
        ? done(...answered(() => answer(this.map!)))
        : done({ code: grpc.status.UNIMPLEMENTED, details: "unknown method" });
    const service = {
      getMapVersion: unary("/dcloc.v1.MapService/GetMapVersion"),
      readMapTile: unary("/dcloc.v1.MapService/ReadMapTile"),
      listMapBuilds: unary("/dcloc.v1.MapService/ListMapBuilds"),
      cancelMapBuild: unary("/dcloc.v1.MapService/CancelMapBuild"),
      listReplicas: unary("/dcloc.v1.AdminService/ListReplicas"),
      listSessions: unary("/dcloc.v1.AdminService/ListSessions"),
      listMaps: unary("/dcloc.v1.MapService/ListMaps"),
    };
    this.server.addService(service, {
      listSessions: (_: unknown, done: grpc.sendUnaryData<Buffer>) => {
        ++this.listCount;
        const { sessions, unanswered } = this;
        const answer = create(ListSessionsResponseSchema, { sessions, unanswered });
        done(null, asOfNewer(toBinary(ListSessionsResponseSchema, answer)));
      },
      listReplicas: (_: unknown, done: grpc.sendUnaryData<Buffer>) => {
        if (!this.replicas) return done({ code: grpc.status.UNIMPLEMENTED, details: "unknown method" });
        const answer = create(ListReplicasResponseSchema, { replicas: this.replicas });
        return done(null, asOfNewer(toBinary(ListReplicasResponseSchema, answer)));
      },
      listMapBuilds: (_: unknown, done: grpc.sendUnaryData<Buffer>) => {
        const answer = create(ListMapBuildsResponseSchema, { builds: this.builds });
        done(null, Buffer.from(toBinary(ListMapBuildsResponseSchema, answer)));
      },
      cancelMapBuild: (call: { request: Buffer }, done: grpc.sendUnaryData<Buffer>) => {
        const { buildId } = fromBinary(CancelMapBuildRequestSchema, call.request);
        const build = this.builds.find((b) => b.buildId === buildId)!;
        build.state = MapBuildState.CANCELLED;
        const answer = create(CancelMapBuildResponseSchema, { build });
        done(null, Buffer.from(toBinary(CancelMapBuildResponseSchema, answer)));
      },
      getMapVersion: (_: unknown, done: grpc.sendUnaryData<Buffer>) =>
        asked(done, ({ version }) =>
          toBinary(GetMapVersionResponseSchema, create(GetMapVersionResponseSchema, { version })),
        ),
      readMapTile: (call: { request: Buffer }, done: grpc.sendUnaryData<Buffer>) =>
        asked(done, ({ readTile }) =>
          toBinary(
            ReadMapTileResponseSchema,
            readTile(fromBinary(ReadMapTileRequestSchema, call.request)),
          ),
        ),
      listMaps: (_: unknown, done: grpc.sendUnaryData<Buffer>) =>
        done(null, Buffer.from(toBinary(ListMapsResponseSchema, create(ListMapsResponseSchema)))),
    });
    const insecure = grpc.ServerCredentials.createInsecure();
    const port = await new Promise<number>((resolve, reject) =>
      this.server.bindAsync("127.0.0.1:0", insecure, (error, taken) =>
        error ? reject(error) : resolve(taken),
      ),
    );
    return `127.0.0.1:${port}`;
  }

  stop(): void {
    this.server.forceShutdown();
  }
}

/** A session at a place, as a server lists it. */
export function sessionAt(
  sessionId: string,
  vehicleId: string,
  state: number,
  x: number,
  y: number,
): Session {
  const covariance = new Array<number>(36).fill(0);
  covariance[0] = covariance[7] = 0.04;
  return create(SessionSchema, {
    sessionId,
    vehicleId,
    mapName: "town",
    mapVersion: 1n,
    state,
    pose: { pose: { translationM: { x, y, z: 0 }, rotation: { w: 1, x: 0, y: 0, z: 0 } }, covariance },
  });
}
