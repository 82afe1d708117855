import { useEffect, useState } from "preact/hooks";

const CHANGED = "dcloc-route";

/** Goes to a view of the page; the browser's back button comes back. */
export function go(path: string): void {
  history.pushState(null, "", path);
  dispatchEvent(new Event(CHANGED));
}

/** The parts of the address: of /maps/town these are "maps" and "town". */
export function useRoute(): string[] {
  const [path, setPath] = useState(location.pathname);
  useEffect(() => {
    const onChange = (): void => setPath(location.pathname);
    addEventListener("popstate", onChange);
    addEventListener(CHANGED, onChange);
    return () => {
      removeEventListener("popstate", onChange);
      removeEventListener(CHANGED, onChange);
    };
  }, []);
  return path.split("/").slice(1).map(decodePart);
}

function decodePart(part: string): string {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}

export const pathOf = (...parts: (string | number)[]): string =>
  `/${parts.map((part) => encodeURIComponent(part)).join("/")}`;
