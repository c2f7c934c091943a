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

/** Copies a link to the present view to the clipboard, and says what its receiver needs. */
export async function copyLink(address: AddressBar, toast: Toast): Promise<void> {
  address.write();
  const { volume, scene, src } = readUrl(location.search);
  if (location.protocol === "file:") toast.note(pageTexts.noLinkOfFile);
  else if (!volume && !scene && !src) toast.note(pageTexts.noLinkOfScene);
  else {
    const { href, needs } = await sharedLink(new URL(location.href));
    try {
      await navigator.clipboard.writeText(href);
      if (needs) toast.note(`${pageTexts.linkCopied}. ${needs}`);
      else toast.done(pageTexts.linkCopied);
    } catch {
      toast.note(pageTexts.noClipboard);
    }
  }
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
