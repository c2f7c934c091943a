import { html, render } from "lit";
import type { VolumeCandidate } from "../device/index.ts";
import { formatBytes } from "./format.ts";

/** Of so many volumes, the largest are offered. */
const mostOffered = 20;

/** Asks which of several volumes to open. Resolves to its path; undefined: none, or cancelled. */
export async function chooseVolume(
  volumes: readonly VolumeCandidate[],
): Promise<string | undefined> {
  if (volumes.length < 2) return volumes[0]?.path;
  await import("./components.ts");
  const holder = document.createElement("div");
  document.body.append(holder);
  return new Promise((resolve) => {
    const end = (path: string | undefined) => {
      resolve(path);
      holder.remove();
    };
    render(
      html`<wa-dialog
        label=${`${volumes.length} volumes: which one?`}
        open
        @wa-after-hide=${(event: Event) => {
          if (event.target === holder.firstElementChild) end(undefined);
        }}
      >
        <div class="device-form">
          ${volumes.slice(0, mostOffered).map(
            ({ path, format, bytes }) =>
              html`<wa-button appearance="outlined" size="s" @click=${() => end(path)}
                >${path === "." ? "the files themselves" : path} · ${format} · ${formatBytes(bytes)}</wa-button
              >`,
          )}
        </div>
      </wa-dialog>`,
      holder,
    );
  });
}
