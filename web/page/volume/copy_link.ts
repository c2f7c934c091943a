import { pageTexts } from "../../texts/page.ts";
import type { AddressBar } from "../address/page_address.ts";
import { idOnDevice } from "../address/target.ts";
import { readUrl } from "../address/url_state.ts";
import type { Toast } from "../shell/toast.ts";

/** A link that others can open, and what they need besides: a sentence for the visitor, or nothing. */
interface SharedLink {
  href: string;
  needs: string;
}

/** Whether the system of this device can share links, as phones can. */
export const canShare = typeof navigator.share === "function";

/** Copies a link to the present view to the clipboard, and says what its receiver needs. */
export async function copyLink(address: AddressBar, toast: Toast): Promise<void> {
  const link = await presentLink(address, toast);
  if (!link) return;
  const { href, needs } = link;
  try {
    await navigator.clipboard.writeText(href);
    if (needs) toast.note(`${pageTexts.linkCopied}. ${needs}`);
    else toast.done(pageTexts.linkCopied);
  } catch {
    toast.note(pageTexts.noClipboard);
  }
}

/** Offers a link to the present view to other programs of this device, and says what its receiver needs. */
export async function shareLink(address: AddressBar, toast: Toast, title: string): Promise<void> {
  const link = await presentLink(address, toast);
  if (!link) return;
  try {
    await navigator.share({ title, url: link.href });
    if (link.needs) toast.note(link.needs);
  } catch (error) {
    const isCancelled = error instanceof DOMException && error.name === "AbortError";
    if (!isCancelled) toast.note(pageTexts.noSharing);
  }
}

/** A link to the present view. Undefined, after a note, if there is none. */
async function presentLink(address: AddressBar, toast: Toast): Promise<SharedLink | undefined> {
  address.write();
  const { volume, scene, src } = readUrl(location.search);
  if (location.protocol === "file:") toast.note(pageTexts.noLinkOfFile);
  else if (!volume && !scene && !src) toast.note(pageTexts.noLinkOfScene);
  else return sharedLink(new URL(location.href));
  return undefined;
}

/** The link to a page with this address. A volume that was fetched is named by the address that it came from. */
async function sharedLink(page: URL): Promise<SharedLink> {
  const { src, layers = [] } = readUrl(page.search);
  const id = idOnDevice(src);
  const ids = [id, ...layers.map((layer) => idOnDevice(layer.src))].filter(
    (each) => each !== undefined,
  );
  const stores = await keptOf(ids);
  const store = id === undefined ? undefined : stores.get(id);
  const needed = new Set(ids);
  if (id !== undefined && store?.address !== undefined) {
    page.searchParams.set("src", store.address);
    needed.delete(id);
  } else if (store) {
    page.searchParams.set("file", store.name);
  }
  const needs: string[] = [];
  if (needed.size > 0) {
    const names = [...needed].map((each) => stores.get(each)?.name ?? `${each.slice(0, 8)}…`);
    needs.push(pageTexts.linkNeedsFile(names.join(", ")));
  }
  if (/^(localhost|127\.\d+\.\d+\.\d+|\[::1\])$/.test(page.hostname)) {
    needs.push(pageTexts.linkOfThisComputer);
  }
  return { href: page.href, needs: needs.join(" ") };
}

/** The stores of this device with these content ids. */
async function keptOf(
  ids: readonly string[],
): Promise<Map<string, { name: string; address?: string }>> {
  const found = new Map<string, { name: string; address?: string }>();
  if (ids.length === 0) return found;
  const { keptBlob } = await import("../../device/kept_stores.ts");
  for (const id of ids) {
    const kept = await keptBlob(id).catch(() => undefined);
    if (kept) found.set(id, kept.store);
  }
  return found;
}
