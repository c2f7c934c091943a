import { registerOffline } from "../../offline/registration.ts";
import { deviceTexts } from "../../texts/device.ts";

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
  const notice = document.createElement("section");
  notice.className = "task-card update-notice";
  notice.setAttribute("role", "status");
  const button = (text: string, pressed: () => void): HTMLButtonElement => {
    const element = document.createElement("button");
    element.type = "button";
    element.className = "chip";
    element.textContent = text;
    element.addEventListener("click", pressed);
    return element;
  };
  const text = document.createElement("p");
  text.textContent = deviceTexts.newVersion;
  notice.append(
    text,
    button(deviceTexts.reload, replace),
    button(deviceTexts.later, () => notice.remove()),
  );
  document.body.append(notice);
}
