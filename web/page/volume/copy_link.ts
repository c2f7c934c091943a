import { pageTexts } from "../../texts/page.ts";
import type { AddressBar } from "../address/page_address.ts";
import type { Toast } from "../shell/toast.ts";

/** Copies the address of the present view to the clipboard. */
export async function copyLink(address: AddressBar, toast: Toast): Promise<void> {
  address.write();
  try {
    await navigator.clipboard.writeText(location.href);
    toast.done(pageTexts.linkCopied);
  } catch {
    toast.note(pageTexts.noClipboard);
  }
}
