import { useEffect, useRef, useState } from "preact/hooks";
import { FailureNotice, Loading } from "./parts/notice.tsx";
import { Link } from "./parts/link.tsx";
import { useRoute } from "./parts/route.ts";
import { TenantSelect } from "./parts/tenant_select.tsx";
import { Shelf } from "./recording/shelf.ts";
import { type Theme, chooseTheme, currentTheme } from "./theme.ts";
import {
  LANGUAGE_NAMES,
  type Language,
  chooseLanguage,
  currentLanguage,
  t,
} from "./texts/texts.ts";
import { CompareView } from "./views/compare.tsx";
import { LiveView } from "./views/live.tsx";
import { MapView } from "./views/map.tsx";
import { MapsView } from "./views/maps.tsx";
import { RecordingsView } from "./views/recordings.tsx";
import { ReplayView } from "./views/replay.tsx";
import { ServersView } from "./views/servers.tsx";
import { SessionView } from "./views/session.tsx";
import { SignIn } from "./views/sign_in.tsx";
import { type ServerName, type Visit, readVisit, signOut } from "./wire/calls.ts";
import { Code, failureOf, type CallFailure } from "./wire/failure.ts";
import { currentTenant, enterTenant } from "./wire/tenant.ts";
import { type FleetLink, useFleet } from "./wire/use_fleet.ts";

/** Signs in, and then shows the view that the address names. */
export function Shell() {
  const [visit, setVisit] = useState<Visit>();
  const [failure, setFailure] = useState<CallFailure>();
  const [wasEnded, setWasEnded] = useState(false);
  const [, setRound] = useState(0);
  const load = (): void => {
    setFailure(undefined);
    readVisit().then(setVisit, (error: unknown) => setFailure(failureOf(error)));
  };
  useEffect(load, []);

  const shelf = useShelfOfPage();
  const settings = <Settings onChange={() => setRound((n) => n + 1)} />;
  if (failure) return <FailureNotice failure={failure} retry={load} />;
  if (!visit) return <Loading />;
  if (!visit.signedIn) {
    const onVisit = (next: Visit): void => {
      setWasEnded(false);
      setVisit(next);
    };
    return <SignIn wasEnded={wasEnded} onVisit={onVisit} settings={settings} />;
  }
  const onRefused = (): void => {
    enterTenant("");
    setWasEnded(true);
    setVisit({ signedIn: false });
    void signOut();
  };
  const onSignOut = (): void => {
    shelf.clear();
    enterTenant("");
    void signOut().then(setVisit, () => undefined);
  };
  const actions = { onRefused, onSignOut, onEnter: () => setRound((n) => n + 1) };
  // Another tenant's fleet and maps have nothing in common with what was shown.
  return <Console key={currentTenant()} visit={visit} shelf={shelf} settings={settings} {...actions} />;
}

/** Recordings stay while the page is open, though somebody may have to sign in again. */
function useShelfOfPage(): Shelf {
  const made = useRef<Shelf>();
  const shelf = (made.current ??= new Shelf());
  useEffect(() => {
    const onLeave = (event: BeforeUnloadEvent): void => {
      if (shelf.hasUnsaved) event.preventDefault();
    };
    addEventListener("beforeunload", onLeave);
    return () => removeEventListener("beforeunload", onLeave);
  }, [shelf]);
  return shelf;
}

function Settings({ onChange }: { onChange: () => void }) {
  const other: Theme = currentTheme() === "dark" ? "light" : "dark";
  const name = t(other === "dark" ? "theme_dark" : "theme_light");
  const onTheme = (): void => {
    chooseTheme(other);
    onChange();
  };
  return (
    <div class="settings">
      <button type="button" class="quiet" onClick={onTheme} aria-label={name} title={name}>
        <svg viewBox="0 0 16 16" width="16" height="16" aria-hidden="true">
          <circle cx="8" cy="8" r="6.200" fill="none" stroke="currentColor" stroke-width="1.500" />
          <path d="M8 1.800a6.200 6.200 0 0 1 0 12.400z" fill="currentColor" />
        </svg>
      </button>
      <select
        class="quiet"
        aria-label={t("language")}
        value={currentLanguage()}
        onChange={(event) => {
          chooseLanguage(event.currentTarget.value as Language);
          onChange();
        }}
      >
        {Object.entries(LANGUAGE_NAMES).map(([key, text]) => (
          <option key={key} value={key}>
            {text}
          </option>
        ))}
      </select>
    </div>
  );
}

interface ConsoleProps {
  visit: Visit;
  shelf: Shelf;
  onRefused: () => void;
  onSignOut: () => void;
  /** Another tenant is looked at. */
  onEnter: () => void;
  settings: preact.ComponentChild;
}

function Console({ visit, shelf, onRefused, onSignOut, onEnter, settings }: ConsoleProps) {
  const fleet = useFleet();
  const servers = visit.servers ?? [];
  const refusedBy = [...fleet.fleet.faults.values()].filter((f) => f.code === Code.Unauthenticated);
  const isRefused = fleet.link === "refused" || refusedBy.length === servers.length;
  useEffect(() => {
    if (isRefused) onRefused();
  }, [isRefused]);
  return (
    <>
      <a class="skip" href="#content">
        {t("skip")}
      </a>
      <TopBar servers={servers} onSignOut={onSignOut} onEnter={onEnter} settings={settings} />
      {fleet.link === "cut" && (
        <div class="cut" role="alert">
          {t("cut_off")}
        </div>
      )}
      <main id="content" tabIndex={0}>
        <View visit={visit} fleet={fleet} shelf={shelf} />
      </main>
    </>
  );
}

interface TopBarProps extends Pick<ConsoleProps, "onSignOut" | "onEnter" | "settings"> {
  servers: readonly ServerName[];
}

function TopBar({ servers, onSignOut, onEnter, settings }: TopBarProps) {
  const [first = ""] = useRoute();
  const views = [
    { path: "/live", name: t("live"), isHere: first === "" || first === "live" || first === "session" },
    { path: "/maps", name: t("maps"), isHere: first === "maps" || first === "compare" },
    { path: "/recordings", name: t("recordings"), isHere: first === "recordings" },
    { path: "/servers", name: t("servers"), isHere: first === "servers" },
  ];
  return (
    <header class="top">
      <span class="brand">
        <svg viewBox="4 2 24 22" width="24" height="22" aria-hidden="true">
          <path d="M5 20a14 14 0 0 1 6.500-9M27 20a14 14 0 0 0-6.500-9" class="brand-waves" />
          <path d="M16 5l7 17-7-3-7 3z" fill="currentColor" />
        </svg>
        dcloc
      </span>
      <nav aria-label={t("main_navigation")}>
        {views.map(({ path, name, isHere }) => (
          <Link key={path} to={path} current={isHere}>
            {name}
          </Link>
        ))}
      </nav>
      <TenantSelect servers={servers} onEnter={onEnter} />
      {settings}
      <button class="quiet" onClick={onSignOut}>
        {t("sign_out")}
      </button>
    </header>
  );
}

function View({ visit, fleet, shelf }: Pick<ConsoleProps, "visit" | "shelf"> & { fleet: FleetLink }) {
  const [first = "", second = "", third = "", fourth = "", fifth = ""] = useRoute();
  const servers = visit.servers ?? [];
  if (first === "maps" && third !== "") return <MapView server={second} name={third} fleet={fleet} />;
  if (first === "maps") return <MapsView servers={servers} fleet={fleet} />;
  if (first === "compare") {
    return <CompareView server={second} map={third} from={Number(fourth)} to={Number(fifth)} />;
  }
  if (first === "servers") return <ServersView servers={servers} />;
  if (first === "session") {
    return <SessionView key={`${second}/${third}`} server={second} id={third} fleet={fleet} shelf={shelf} />;
  }
  if (first === "recordings" && second !== "") {
    return <ReplayView shelf={shelf} id={second} servers={servers} />;
  }
  if (first === "recordings") return <RecordingsView shelf={shelf} servers={servers} />;
  return <LiveView fleet={fleet} servers={servers} />;
}
