import { pageTexts } from "../../texts/page.ts";
import type { Toast } from "../shell/toast.ts";

/** Copies the address of the page to the clipboard. */
export async function copyLink(toast: Toast): Promise<void> {
  try {
    await navigator.clipboard.writeText(location.href);
    toast.done(pageTexts.linkCopied);
  } catch {
    toast.note(pageTexts.noClipboard);
  }
}
