/** A server of its own process with a large fleet on a large map, for measure/goals.ts. */
import { FakeServer } from "../browser/fake_server.ts";
import { LARGE_MAP, LargeFleet } from "./large_fleet.ts";

const VEHICLE_COUNT = Number(process.argv[2]);

const fake = new FakeServer();
const fleet = new LargeFleet(VEHICLE_COUNT);
const begin = Date.now();
fake.map = LARGE_MAP;
// Whenever the list is asked for, the vehicles are where they are then.
Object.defineProperty(fake, "sessions", { get: () => fleet.at((Date.now() - begin) / 1000) });
void fake.start().then((address) => console.log(`listening on ${address}`));
