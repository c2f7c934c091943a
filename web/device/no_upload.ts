import { startWorkersWithPagePolicy } from "../core/page_worker.ts";

/**
 * From now on, the browser refuses every request of this page, and of workers that it starts, to
 * another origin. Call it before a file of this device is read. The policy holds until the page is
 * left.
 */
export function forbidOtherOrigins(): void {
  if (isForbidden()) return;
  const policy = document.createElement("meta");
  policy.httpEquiv = "Content-Security-Policy";
  policy.content = "connect-src 'self' data: blob:; form-action 'none'";
  policy.dataset.noUpload = "";
  document.head.append(policy);
  startWorkersWithPagePolicy();
}

/** Whether the browser refuses requests of this page to an address. */
export function isForbiddenAddress(address: URL): boolean {
  return isForbidden() && address.origin !== location.origin;
}

function isForbidden(): boolean {
  return document.querySelector("meta[data-no-upload]") !== null;
}
