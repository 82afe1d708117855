import { de } from "./de.ts";
import { type TextKey, en } from "./en.ts";
import { visible } from "./shortened.ts";

export type { TextKey };

const LANGUAGES = { en, de } as const;
export type Language = keyof typeof LANGUAGES;
export const LANGUAGE_NAMES: Record<Language, string> = { en: "English", de: "Deutsch" };

const STORED = "dcloc.language";

function firstLanguage(): Language {
  const wanted = localStorage.getItem(STORED) ?? navigator.language.slice(0, 2);
  return wanted in LANGUAGES ? (wanted as Language) : "en";
}

let language: Language = firstLanguage();

export function currentLanguage(): Language {
  return language;
}

export function chooseLanguage(chosen: Language): void {
  language = chosen;
  localStorage.setItem(STORED, chosen);
  document.documentElement.lang = chosen;
}

/** The text in the chosen language, with {names} replaced. */
export function t(key: TextKey, values: Record<string, string | number> = {}): string {
  const text: string = LANGUAGES[language][key];
  return text.replace(/\{(\w+)\}/g, (whole, name: string) => {
    const value = values[name] ?? whole;
    return typeof value === "string" ? visible(value) : String(value);
  });
}

/** A text whose key is made of a number that a newer server may not have told us of. */
export function numbered(prefix: string, value: number, otherwise: string): string {
  const key = `${prefix}${value}`;
  return key in en ? t(key as TextKey) : otherwise;
}

/** How numbers and times are written: as where the browser is, if the language is spoken there. */
function locale(): string {
  return navigator.language.startsWith(language) ? navigator.language : language;
}

/** Made once: a browser takes longer to make one than to use it a hundred times. */
const formats = new Map<string, Intl.NumberFormat>();

export function decimals(value: number, digits: number): string {
  const key = `${language}/${digits}`;
  let format = formats.get(key);
  if (!format) {
    const options = { minimumFractionDigits: digits, maximumFractionDigits: digits };
    format = new Intl.NumberFormat(locale(), options);
    formats.set(key, format);
  }
  return format.format(value);
}

export const count = (value: number): string => decimals(value, 0);

export function kilometres(metres: number): string {
  return `${decimals(metres / 1000, metres < 100_000 ? 2 : 0)} km`;
}

export function megabytes(bytes: number): string {
  return bytes < 1e6 ? `${decimals(bytes / 1e3, 0)} kB` : `${decimals(bytes / 1e6, 1)} MB`;
}

export function dateTime(ms: number): string {
  return new Date(ms).toLocaleString(locale(), { dateStyle: "medium", timeStyle: "short" });
}

/** Minutes and seconds, as of a recording; before it they are negative. */
export function clock(ms: number): string {
  const seconds = Math.round(Math.abs(ms) / 100) / 10;
  const rest = decimals(seconds % 60, 1).padStart(4, "0");
  return `${ms < 0 ? "−" : ""}${Math.floor(seconds / 60)}:${rest}`;
}
