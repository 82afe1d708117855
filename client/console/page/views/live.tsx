import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { MapService } from "proto/dcloc/v1/map_service_pb.ts";
import { extentOf, extentOfVehicles } from "../map/extent.ts";
import { Fleet, State, type Vehicle } from "../map/fleet.ts";
import { MapCanvas } from "../map/map_canvas.tsx";
import { FailureNotice, Loading, Notice } from "../parts/notice.tsx";
import { useCall } from "../parts/use_call.ts";
import { shortened, shownName } from "../texts/shortened.ts";
import { t } from "../texts/texts.ts";
import { type ServerName, call } from "../wire/calls.ts";
import { CallFailure, Code } from "../wire/failure.ts";
import type { FleetLink } from "../wire/use_fleet.ts";
import { LossAlarm, LossPanel, WHOLE_HOUR, lossesWithin } from "./losses.tsx";
import { type Filter, NO_FILTER, VehicleList, matches, worstFirst } from "./vehicle_list.tsx";

/** A map of a server: each has a frame of its own, so one is shown at a time. */
interface Place {
  server: string;
  map: string;
}

const NO_MAPS: Place[] = [];

const placeKey = ({ server, map }: Place): string => `${server}/${map}`;

/** The places with vehicles, the one with the most first, and then the other maps. */
function placesOf(fleet: Fleet, maps: readonly Place[]): Place[] {
  const counts = new Map<string, Place & { count: number }>();
  for (const { server, map } of [...fleet.vehicles.values(), ...maps]) {
    const key = placeKey({ server, map });
    if (!counts.has(key)) counts.set(key, { server, map, count: 0 });
  }
  for (const vehicle of fleet.vehicles.values()) counts.get(placeKey(vehicle))!.count += 1;
  return [...counts.values()].sort((a, b) => b.count - a.count || a.map.localeCompare(b.map));
}

function useMaps(servers: readonly ServerName[]): Place[] {
  const { value } = useCall(
    async (signal) => {
      const lists = await Promise.allSettled(
        servers.map(async ({ name }) => {
          const { maps } = await call(name, MapService.method.listMaps, {}, signal);
          return maps.map((map) => ({ server: name, map: map.name }));
        }),
      );
      return lists.flatMap((list) => (list.status === "fulfilled" ? list.value : []));
    },
    [servers.length],
    30_000,
  );
  return value ?? NO_MAPS;
}

/** The active version of a map and where it lies. */
function useActiveVersion(place: Place | undefined) {
  return useCall(
    async (signal) => {
      if (!place) return undefined;
      const request = { mapName: place.map };
      return (await call(place.server, MapService.method.getMapVersion, request, signal)).version;
    },
    [place && placeKey(place)],
    60_000,
  );
}

/** The vehicles on their map, and in words beside it. */
export function LiveView({ fleet, servers }: { fleet: FleetLink; servers: readonly ServerName[] }) {
  const [chosenPlace, setPlace] = useState<string>();
  const [chosen, setChosen] = useState<string>();
  const [follow, setFollow] = useState(false);
  const [filter, setFilter] = useState<Filter>(NO_FILTER);
  const [showHeat, setShowHeat] = useState(true);
  const [lossWindow, setLossWindow] = useState(WHOLE_HOUR);
  const maps = useMaps(servers);
  const places = useMemo(() => placesOf(fleet.fleet, maps), [fleet.fleet, fleet.tick, maps]);
  // The first one with vehicles stays, though other maps may get more.
  const first = useRef<string>();
  if (!first.current && places[0] && fleet.fleet.vehicles.size > 0) first.current = placeKey(places[0]);
  const wanted = chosenPlace ?? first.current;
  const place = places.find((p) => placeKey(p) === wanted) ?? places[0];
  const active = useActiveVersion(place);

  const key = place && placeKey(place);
  const inPlace = useMemo(
    () => [...fleet.fleet.vehicles.values()].filter((v) => placeKey(v) === key),
    [fleet.fleet, fleet.tick, key],
  );
  const shown = useMemo(() => inPlace.filter((v) => matches(v, filter)).sort(worstFirst), [inPlace, filter]);
  const losses = useMemo(
    () => fleet.fleet.losses.filter((l) => placeKey(l) === key),
    [fleet.fleet.losses, key],
  );
  const extent = useExtent(active.value?.info && extentOf(active.value.info), inPlace);

  if (fleet.fleet.heardOf.size === 0) return <Loading />;
  if (!place) return <NoPlaces fleet={fleet.fleet} />;
  const onChoose = (vehicle: Vehicle | undefined): void => {
    setChosen(vehicle && Fleet.key(vehicle.server, vehicle.id));
    if (!vehicle) setFollow(false);
  };
  // Versions and servers are those of a map: another one may have none of them.
  const onPlace = (next: string): void => {
    setPlace(next);
    setFilter({ ...filter, version: NO_FILTER.version, replica: NO_FILTER.replica });
  };
  const version = Number(active.value?.version ?? 0n);
  return (
    <div class="live">
      <VehicleList
        vehicles={inPlace}
        shown={shown}
        filter={filter}
        onFilter={setFilter}
        chosen={chosen}
        onChoose={onChoose}
        follow={follow}
        onFollow={setFollow}
      >
        <label class="place">
          {t("map")}
          <select value={placeKey(place)} onChange={(e) => onPlace(e.currentTarget.value)}>
            {places.map((p) => (
              <option key={placeKey(p)} value={placeKey(p)}>
                {servers.length > 1 ? `${shownName(p.map)} · ${p.server}` : shownName(p.map)}
              </option>
            ))}
          </select>
        </label>
        <Faults fleet={fleet.fleet} />
      </VehicleList>
      <div class="stage">
        <MapCanvas
          map={version > 0 ? { server: place.server, name: place.map, version } : undefined}
          extent={extent}
          vehicles={() => shown}
          losses={showHeat ? lossesWithin(losses, lossWindow, performance.now()) : []}
          chosen={chosen}
          follow={follow}
          onChoose={onChoose}
          tick={fleet.tick}
        />
        <div class="over-map">
          <LossAlarm losses={losses} />
          <LossPanel
            losses={losses}
            window={lossWindow}
            onWindow={setLossWindow}
            isShown={showHeat}
            onShown={setShowHeat}
          />
        </div>
      </div>
      <Announcements vehicles={inPlace} />
    </div>
  );
}

/** The map's own extent; where it is not known, that of the vehicles as they were first seen. */
function useExtent(ofMap: ReturnType<typeof extentOf>, vehicles: readonly Vehicle[]) {
  const ofVehicles = useRef<ReturnType<typeof extentOf>>();
  if (!ofMap) ofVehicles.current ??= extentOfVehicles(vehicles);
  const { minX, minY, maxX, maxY } = ofMap ?? ofVehicles.current ?? {};
  return useMemo(() => ofMap ?? ofVehicles.current, [minX, minY, maxX, maxY]);
}

function NoPlaces({ fleet }: { fleet: Fleet }) {
  const [fault] = fleet.faults.values();
  if (fault) return <FailureNotice failure={new CallFailure(fault.code, fault.message)} />;
  return (
    <Notice title={t("no_vehicles_title")}>
      <p>{t("no_vehicles_text")}</p>
    </Notice>
  );
}

/** Servers whose vehicles are not, or no longer, known. */
function Faults({ fleet }: { fleet: Fleet }) {
  return (
    <>
      {[...fleet.faults].map(([server, { code }]) => (
        <p key={server} class="fault small" role="alert">
          {t(code === Code.PermissionDenied ? "no_permission_sessions" : "old_figures", { server })}
        </p>
      ))}
      {[...fleet.silent].map(([server, replicas]) =>
        replicas.map(({ address, fault }) => (
          <p key={`${server}/${address}`} class="fault small" role="alert" title={shortened(fault)}>
            {t("old_figures", { server: shownName(address) })}
          </p>
        )),
      )}
    </>
  );
}

/** Says to who does not see the map which vehicles have got lost. */
function Announcements({ vehicles }: { vehicles: readonly Vehicle[] }) {
  const before = useRef(new Set<string>());
  const [text, setText] = useState("");
  const lost = vehicles.filter((v) => v.state === State.Lost).map((v) => v.vehicle);
  const key = lost.join();
  useEffect(() => {
    const news = lost.filter((name) => !before.current.has(name));
    before.current = new Set(lost);
    if (news.length > 0) setText(news.map((vehicle) => t("just_lost", { vehicle: shownName(vehicle) })).join(" "));
  }, [key]);
  return (
    <div class="unseen" aria-live="polite">
      {text}
    </div>
  );
}
