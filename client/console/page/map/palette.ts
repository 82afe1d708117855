import { ACCURACY_GRADES } from "./accuracy_grade.ts";

/** Red, green, blue, each of 255. */
export type Rgb = readonly [number, number, number];

/** The colours of the canvases, read from the style sheet: one place has them. */
export interface Palette {
  theme: string;
  ground: string;
  grid: string;
  gridText: string;
  /** Of mapped street, by `ACCURACY_GRADES`. */
  street: Rgb[];
  landmark: Rgb;
  ink: string;
  halo: string;
  states: string[];
  heat: Rgb;
  /** Of range rates. */
  approaching: Rgb;
  still: Rgb;
  receding: Rgb;
  /** Of landmarks that two versions have in common, or one of them alone. */
  both: string;
  onlyFrom: string;
  onlyTo: string;
}

const NUMBERS = /\d+/g;

export function readPalette(): Palette {
  const style = getComputedStyle(document.documentElement);
  const value = (name: string): string => style.getPropertyValue(name).trim();
  const numbers = (name: string): Rgb => {
    const [r = 0, g = 0, b = 0] = (value(name).match(NUMBERS) ?? []).map(Number);
    return [r, g, b];
  };
  return {
    theme: value("--theme"),
    ground: value("--map-ground"),
    grid: value("--map-grid"),
    gridText: value("--text-soft"),
    street: ACCURACY_GRADES.map((grade) => numbers(`--map-street-${grade}`)),
    landmark: numbers("--map-landmark"),
    ink: value("--text"),
    halo: value("--map-ground"),
    states: [0, 1, 2, 3, 4].map((state) => value(`--state-${state}`)),
    heat: numbers("--map-heat"),
    approaching: numbers("--rate-approaching"),
    still: numbers("--rate-still"),
    receding: numbers("--rate-receding"),
    both: value("--map-both"),
    onlyFrom: value("--map-only-from"),
    onlyTo: value("--map-only-to"),
  };
}
