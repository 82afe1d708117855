const STORED = "dcloc.tenant";

let tenant = "";

/** A page that is loaded again shows the same tenant. */
export function startTenant(): void {
  tenant = sessionStorage.getItem(STORED) ?? "";
}

/** The tenant that is looked at; empty: that of the visitor's token. */
export const currentTenant = (): string => tenant;

export function enterTenant(name: string): void {
  tenant = name;
  sessionStorage.setItem(STORED, name);
}

/** An address of the bridge, with the tenant whose data is wanted. */
export function inTenant(address: string): string {
  if (tenant === "") return address;
  return `${address}${address.includes("?") ? "&" : "?"}tenant=${encodeURIComponent(tenant)}`;
}
