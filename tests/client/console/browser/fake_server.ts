import * as grpc from "@grpc/grpc-js";
import {
  type DescMessage,
  type DescMethod,
  type MessageInitShape,
  type MessageShape,
  create,
  fromBinary,
  toBinary,
} from "@bufbuild/protobuf";
import {
  AdminService,
  type Replica,
  type ReplicaFault,
  type Session,
  SessionSchema,
} from "proto/dcloc/v1/admin_service_pb.ts";
import {
  type MapBuild,
  MapBuildState,
  MapService,
  type MapVersion,
  type ReadMapTileRequest,
  type ReadMapTileResponse,
} from "proto/dcloc/v1/map_service_pb.ts";

/** A map as the server serves it. */
export interface FakeMap {
  version: MapVersion;
  readTile(request: ReadMapTileRequest): ReadMapTileResponse;
}

/** A call that fails. */
export class Refusal extends Error {
  constructor(
    readonly code: grpc.status,
    message: string,
  ) {
    super(message);
  }
}

const UNKNOWN = new Refusal(grpc.status.UNIMPLEMENTED, "unknown method");
const asIs = (bytes: Buffer): Buffer => bytes;

/** An answer with a field that this version of the contract does not have: number 4000, a text. */
function asOfNewer(bytes: Uint8Array): Buffer {
  const text = Buffer.from("news");
  return Buffer.concat([bytes, Buffer.from([0x82, 0xfa, 0x01, text.length]), text]);
}

type Answer = (request: Buffer) => Buffer[];

/** A method whose input and output are known. */
type Method<I extends DescMessage, O extends DescMessage> = DescMethod & { input: I; output: O };

/** A server that says anything at all: as much, and as strange, as no real one would. */
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
  private readonly answers = new Map<DescMethod, Answer>();
  private readonly server = new grpc.Server();

  constructor() {
    const { method: maps } = MapService;
    const { method: admin } = AdminService;
    const known = <T>(value: T | undefined): T => {
      if (value === undefined) throw UNKNOWN;
      return value;
    };
    this.on(admin.listSessions, () => {
      ++this.listCount;
      return { sessions: this.sessions, unanswered: this.unanswered };
    });
    this.on(admin.listReplicas, () => ({ replicas: known(this.replicas) }));
    this.on(maps.listMaps, () => ({}));
    this.on(maps.listMapBuilds, () => ({ builds: this.builds }));
    this.on(maps.cancelMapBuild, ({ buildId }) => {
      const build = this.builds.find((b) => b.buildId === buildId)!;
      build.state = MapBuildState.CANCELLED;
      return { build };
    });
    this.on(maps.getMapVersion, () => ({ version: known(this.map).version }));
    this.on(maps.readMapTile, (request) => known(this.map).readTile(request));
  }

  /** From now on `answer` gives what a method answers; what it throws is the failure of the call. */
  on<I extends DescMessage, O extends DescMessage>(
    method: Method<I, O>,
    answer: (request: MessageShape<I>) => MessageInitShape<O>,
  ): void {
    this.onStream(method, (request) => [answer(request)]);
  }

  /** As `on`, for a method that answers several times. */
  onStream<I extends DescMessage, O extends DescMessage>(
    method: Method<I, O>,
    answer: (request: MessageShape<I>) => MessageInitShape<O>[],
  ): void {
    this.answers.set(method, (request) =>
      answer(fromBinary(method.input, request)).map((each) =>
        asOfNewer(toBinary(method.output, create(method.output, each))),
      ),
    );
  }

  async start(): Promise<string> {
    for (const service of [AdminService, MapService]) {
      for (const method of service.methods) {
        if (method.methodKind === "unary" || method.methodKind === "server_streaming") this.serve(method);
      }
    }
    const insecure = grpc.ServerCredentials.createInsecure();
    const port = await new Promise<number>((resolve, reject) =>
      this.server.bindAsync("127.0.0.1:0", insecure, (error, taken) =>
        error ? reject(error) : resolve(taken),
      ),
    );
    return `127.0.0.1:${port}`;
  }

  private serve(method: DescMethod): void {
    const answersTo = (request: Buffer): Buffer[] => {
      const answer = this.answers.get(method);
      if (!answer) throw UNKNOWN;
      return answer(request);
    };
    const failure = (error: unknown): Partial<grpc.StatusObject> => ({
      code: error instanceof Refusal ? error.code : grpc.status.DATA_LOSS,
      details: (error as Error).message,
    });
    const isStream = method.methodKind === "server_streaming";
    const definition = {
      path: `/${method.parent.typeName}/${method.name}`,
      requestStream: false,
      responseStream: isStream,
      requestSerialize: asIs,
      requestDeserialize: asIs,
      responseSerialize: asIs,
      responseDeserialize: asIs,
    };
    const unary = (call: { request: Buffer }, done: grpc.sendUnaryData<Buffer>): void => {
      try {
        done(null, answersTo(call.request)[0]!);
      } catch (error) {
        done(failure(error));
      }
    };
    // A stream stays open: what it has to say is said, and nobody ends it.
    const stream = (call: grpc.ServerWritableStream<Buffer, Buffer>): void => {
      try {
        const answers = answersTo(call.request);
        call.sendMetadata(new grpc.Metadata());
        for (const bytes of answers) call.write(bytes);
      } catch (error) {
        call.emit("error", failure(error));
      }
    };
    this.server.addService(
      { [method.localName]: definition },
      { [method.localName]: isStream ? stream : unary } as grpc.UntypedServiceImplementation,
    );
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
