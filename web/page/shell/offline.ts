import { registerOffline } from "../../offline/registration.ts";
import { deviceTexts } from "../../texts/device.ts";
import { showPageNotice } from "./page_notice.ts";

/** Makes this page work without a network, once the link is idle. Announces new versions. */
export async function startOffline(): Promise<void> {
  if (!import.meta.env.PROD) return; // the development server has no service worker
  while (document.querySelector('[role="application"][aria-busy="true"]')) {
    await new Promise((resolve) => setTimeout(resolve, 1000));
  }
  await registerOffline(announce);
}

/** Announces a new version. It is used only when the visitor requests it. */
function announce(replace: () => void): void {
  if (document.querySelector(".update-notice")) return;
  const notice = showPageNotice({
    role: "status",
    text: deviceTexts.newVersion,
    buttons: [
      [deviceTexts.reload, replace],
      [deviceTexts.later, () => notice.remove()],
    ],
  });
  notice.className = "task-card update-notice";
}
