// What modules of the page ask of a browser when they are loaded.
Object.assign(globalThis, {
  localStorage: { getItem: () => null, setItem: () => undefined },
  document: { documentElement: {} },
});
Object.defineProperty(globalThis, "navigator", { value: { language: "en" }, configurable: true });
