import type { ComponentChildren } from "preact";
import { useEffect, useState } from "preact/hooks";
import { ellipseOf } from "../map/draw_vehicles.ts";
import { Fleet, type Vehicle } from "../map/fleet.ts";
import { Link } from "../parts/link.tsx";
import { pathOf } from "../parts/route.ts";
import { StateMark } from "../parts/state_mark.tsx";
import { shownName } from "../texts/shortened.ts";
import { count, decimals, t } from "../texts/texts.ts";

/** So many rows at first, and with each press more: a browser is slower, the more rows a page has. */
const ROW_STEP = 50;
/** The worst first. */
const ORDER = [4, 3, 1, 0, 2];
const SIGMAS_OF_95 = 2.4477;

/** Which vehicles are shown. */
export interface Filter {
  text: string;
  /** -1: all. */
  state: number;
  /** 0: all. */
  version: number;
  /** Empty: all. */
  replica: string;
}

export const NO_FILTER: Filter = { text: "", state: -1, version: 0, replica: "" };

export function matches(vehicle: Vehicle, { text, state, version, replica }: Filter): boolean {
  if (state >= 0 && vehicle.state !== state) return false;
  if (version > 0 && vehicle.version !== version) return false;
  if (replica !== "" && vehicle.replica !== replica) return false;
  return vehicle.vehicle.toLowerCase().includes(text.trim().toLowerCase());
}

interface Props {
  vehicles: readonly Vehicle[];
  /** Those that match the filter, in order. */
  shown: readonly Vehicle[];
  filter: Filter;
  onFilter: (filter: Filter) => void;
  chosen: string | undefined;
  onChoose: (vehicle: Vehicle) => void;
  follow: boolean;
  onFollow: (follow: boolean) => void;
  children?: ComponentChildren;
}

function rank(vehicle: Vehicle): number {
  const place = ORDER.indexOf(vehicle.state);
  return place < 0 ? ORDER.length : place;
}

/** Made once: a browser takes longer to make one than to compare with it. */
const names = new Intl.Collator();

/** Orders vehicles: those that need somebody first, and then by name. */
export const worstFirst = (a: Vehicle, b: Vehicle): number =>
  rank(a) - rank(b) || names.compare(a.vehicle, b.vehicle);

/** The vehicles in words, those that need somebody first. */
export function VehicleList(props: Props) {
  const { vehicles, shown, filter, onFilter } = props;
  const [rowCount, setRowCount] = useState(ROW_STEP);
  useEffect(() => setRowCount(ROW_STEP), [filter]);
  const isOldServer = vehicles.length > 0 && vehicles.every((v) => v.state > 1 && !v.pose);
  return (
    <section class="side" aria-label={t("vehicles")}>
      <div class="side-head">
        {props.children}
        <StateFilter vehicles={vehicles} filter={filter} onFilter={onFilter} />
        <div class="filters">
          <input
            type="search"
            placeholder={t("filter_vehicles")}
            aria-label={t("filter_vehicles")}
            value={filter.text}
            onInput={(event) => onFilter({ ...filter, text: event.currentTarget.value })}
          />
          <VersionFilter vehicles={vehicles} filter={filter} onFilter={onFilter} />
          <ReplicaFilter vehicles={vehicles} filter={filter} onFilter={onFilter} />
        </div>
      </div>
      {isOldServer && <p class="hint padded">{t("list_has_no_poses")}</p>}
      {shown.length === 0 && (
        <p class="hint padded">{t(vehicles.length === 0 ? "no_vehicles_text" : "none_match")}</p>
      )}
      <ul class="rows">
        {shown.slice(0, rowCount).map((vehicle) => (
          <Row key={Fleet.key(vehicle.server, vehicle.id)} vehicle={vehicle} {...props} />
        ))}
      </ul>
      {shown.length > rowCount && (
        <p class="hint padded more">
          {t("more_vehicles", { count: count(shown.length - rowCount) })}
          <button onClick={() => setRowCount(rowCount + ROW_STEP)}>{t("show_more")}</button>
        </p>
      )}
    </section>
  );
}

type FilterProps = Pick<Props, "vehicles" | "filter" | "onFilter">;

/** How many vehicles are in each state; a press shows those alone. */
function StateFilter({ vehicles, filter, onFilter }: FilterProps) {
  const counts = new Map<number, number>();
  for (const { state } of vehicles) counts.set(state, (counts.get(state) ?? 0) + 1);
  return (
    <div class="state-filter" role="group" aria-label={t("state")}>
      {[2, 3, 4, 1].map((state) => (
        <button
          key={state}
          class={`tile state-${state}`}
          aria-pressed={filter.state === state}
          onClick={() => onFilter({ ...filter, state: filter.state === state ? -1 : state })}
        >
          <strong>{count(counts.get(state) ?? 0)}</strong>{" "}
          <StateMark state={state} />
        </button>
      ))}
    </div>
  );
}

function VersionFilter({ vehicles, filter, onFilter }: FilterProps) {
  const versions = [...new Set(vehicles.map((v) => v.version))].sort((a, b) => b - a);
  if (versions.length < 2 && filter.version === 0) return null;
  return (
    <select
      aria-label={t("version")}
      value={filter.version}
      onChange={(event) => onFilter({ ...filter, version: Number(event.currentTarget.value) })}
    >
      <option value={0}>{t("all")}</option>
      {versions.map((version) => (
        <option key={version} value={version}>
          {t("version_n", { version })}
        </option>
      ))}
    </select>
  );
}

/** Which server of the fleet has the vehicle, where there are several. */
function ReplicaFilter({ vehicles, filter, onFilter }: FilterProps) {
  const replicas = [...new Set(vehicles.map((v) => v.replica ?? ""))].filter(Boolean).sort();
  if (replicas.length < 2 && filter.replica === "") return null;
  return (
    <select
      aria-label={t("server")}
      value={filter.replica}
      onChange={(event) => onFilter({ ...filter, replica: event.currentTarget.value })}
    >
      <option value="">{t("all_servers")}</option>
      {replicas.map((replica) => (
        <option key={replica} value={replica}>
          {shownName(replica)}
        </option>
      ))}
    </select>
  );
}

function remarksOf(vehicle: Vehicle): string {
  const remarks: string[] = [];
  if (vehicle.pose) {
    const sigma = ellipseOf(vehicle.pose).major / SIGMAS_OF_95;
    remarks.push(t("sigma", { sigma: decimals(sigma, sigma < 1 ? 2 : 1) }));
  } else {
    remarks.push(t("no_pose"));
  }
  if (vehicle.detached) remarks.push(t("detached"));
  if (vehicle.silentS > 0) remarks.push(t("silent_s", { seconds: vehicle.silentS }));
  if (vehicle.faults.length > 0) remarks.push(t("source_fault", { sources: shownName(vehicle.faults.join(", ")) }));
  return remarks.join(" · ");
}

function Row({ vehicle, chosen, onChoose, follow, onFollow }: Props & { vehicle: Vehicle }) {
  const isChosen = Fleet.key(vehicle.server, vehicle.id) === chosen;
  return (
    <li class={isChosen ? "row chosen" : "row"}>
      <button class="row-main" aria-pressed={isChosen} onClick={() => onChoose(vehicle)}>
        <StateMark state={vehicle.state} label={false} />
        <span class="row-text">
          <strong>{shownName(vehicle.vehicle)}</strong>
          <span class="soft">{remarksOf(vehicle)}</span>
        </span>
      </button>
      {isChosen && (
        <div class="row-actions">
          <button aria-pressed={follow} onClick={() => onFollow(!follow)}>
            {t(follow ? "following" : "follow")}
          </button>
          <Link class="button" to={pathOf("session", vehicle.server, vehicle.id)}>
            {t("details")}
          </Link>
        </div>
      )}
    </li>
  );
}
