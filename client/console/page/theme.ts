const STORED = "dcloc.theme";

export type Theme = "dark" | "light";

/** The chosen colours, or else those that the system has. */
export function currentTheme(): Theme {
  const chosen = localStorage.getItem(STORED);
  if (chosen === "dark" || chosen === "light") return chosen;
  return matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark";
}

export function chooseTheme(theme: Theme): void {
  localStorage.setItem(STORED, theme);
  document.documentElement.dataset.theme = theme;
}

export function startTheme(): void {
  document.documentElement.dataset.theme = currentTheme();
}
