import { html, render } from "lit";
import {
  isBuildable,
  type VolumeCandidate,
  type ZarrImage,
  type ZarrScale,
} from "../device/index.ts";
import { deviceTexts } from "../texts/device.ts";
import { formatBytes, formatDims } from "./format.ts";

/** Of so many volumes, the largest are offered. */
const mostOffered = 20;

/** Asks which of several volumes to open. Resolves to undefined: none, or cancelled. */
export async function chooseVolume(
  volumes: readonly VolumeCandidate[],
): Promise<VolumeCandidate | undefined> {
  if (volumes.length < 2) return volumes[0];
  const text = ({ path, choice, format, bytes }: VolumeCandidate) => {
    const name = path === "." ? deviceTexts.theFiles : path;
    return `${name} · ${choice ? choice.label : `${format} · ${formatBytes(bytes)}`}`;
  };
  const label = deviceTexts.whichVolume(volumes.length);
  return choose(label, volumes.slice(0, mostOffered), text);
}

/**
 * Asks which scale of an image to open, unless its address names one. Resolves to undefined if the
 * visitor cancels. Rejects if the browser can build none.
 */
export async function chooseScale({
  scales: all,
  chosen,
}: ZarrImage): Promise<ZarrScale | undefined> {
  const bySize = all
    .filter((_, i) => chosen === undefined || i === chosen)
    .sort((a, b) => b.voxelBytes - a.voxelBytes);
  const scales = bySize.filter(isBuildable);
  const smallest = bySize.at(-1);
  if (scales.length === 0 && smallest) {
    const { description, voxelBytes } = smallest;
    throw new Error(deviceTexts.noScale(description.name, formatBytes(voxelBytes)));
  }
  if (bySize.length === 1) return scales[0];
  const left = bySize.length - scales.length;
  const text = ({ description, voxelBytes }: ZarrScale) =>
    deviceTexts.scale(formatDims(description.voxels), formatBytes(voxelBytes));
  const tooLarge = left > 0 ? ` ${deviceTexts.tooLarge(left)}` : "";
  return choose(deviceTexts.whichScale + tooLarge, scales, text);
}

/** Asks which of several things is meant. Resolves to undefined if the visitor cancels. */
async function choose<T>(
  label: string,
  offered: readonly T[],
  text: (each: T) => string,
): Promise<T | undefined> {
  await import("./components.ts");
  const holder = document.createElement("div");
  document.body.append(holder);
  return new Promise((resolve) => {
    const end = (chosen: T | undefined) => {
      resolve(chosen);
      holder.remove();
    };
    render(
      html`<wa-dialog
        label=${label}
        open
        @wa-after-hide=${(event: Event) => {
          if (event.target === holder.firstElementChild) end(undefined);
        }}
      >
        <div class="device-form">
          ${offered.map(
            (each) =>
              html`<wa-button appearance="outlined" size="s" @click=${() => end(each)}
                >${text(each)}</wa-button
              >`,
          )}
        </div>
      </wa-dialog>`,
      holder,
    );
  });
}
